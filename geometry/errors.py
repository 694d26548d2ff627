"""What can go wrong between dimensions and a solid."""


class GeometryError(RuntimeError):
    """No usable solid came out: what failed, and what to do."""
