"""The errors of writing and showing results."""


class OutputError(Exception):
    """A result could not be written or shown."""


class OccupiedError(OutputError):
    """The output directory contains something other than an earlier run (exit code 2)."""


class StorageError(OutputError):
    """A full disk, a permission or the file system prevents writing (exit code 7)."""


class PictureError(OutputError):
    """No usable picture could be drawn; the result files are not affected (exit code 7)."""
