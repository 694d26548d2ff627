"""Exchange two paths in one atomic step, so that a reader always sees one of them complete."""

import ctypes
import errno
import os
import sys
from pathlib import Path

AT_FDCWD = -100  # Linux: paths are relative to the working directory
RENAME_EXCHANGE = 2
NOT_THERE = {errno.ENOSYS, errno.EINVAL}  # the kernel or the file system does not support the flag


def exchange(one: Path, other: Path) -> bool:
    """Exchange two existing paths on one file system.

    Returns
    -------
    bool
        False if the system cannot do this in one step; then nothing has changed.

    Raises
    ------
    OSError
        The system supports it, but refused.
    """
    if not sys.platform.startswith("linux"):
        return False
    renameat2 = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)  # since glibc 2.28
    if renameat2 is None:
        return False
    if not renameat2(AT_FDCWD, os.fsencode(one), AT_FDCWD, os.fsencode(other), RENAME_EXCHANGE):
        return True
    code = ctypes.get_errno()
    if code in NOT_THERE:
        return False
    raise OSError(code, os.strerror(code), str(one), None, str(other))
