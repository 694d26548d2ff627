"""The error of drawing or importing a solid."""


class GeometryError(RuntimeError):
    """No usable solid could be made; the message says what failed and what to do."""
