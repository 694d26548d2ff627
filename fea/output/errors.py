"""What can go wrong when results leave the program."""


class OutputError(Exception):
    """A result could not be written or shown."""


class OccupiedError(OutputError):
    """The output directory holds something that is not an earlier run (the user's choice: exit 2)."""


class StorageError(OutputError):
    """The disk, a permission or the file system refused (this machine cannot: exit 7)."""


class PictureError(OutputError):
    """No usable picture came out; the result files are not touched by it (this machine cannot: exit 7)."""
