"""The error of meshing a solid."""


class MeshError(RuntimeError):
    """No usable mesh could be made."""
