"""What can go wrong between a solid and its mesh."""


class MeshError(RuntimeError):
    """No usable mesh came out."""
