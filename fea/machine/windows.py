"""Windows' own calls: limits of a process, and locks by name."""

import ctypes
import hashlib
import os
import sys
import threading
import time
from collections.abc import Callable
from ctypes import c_uint32, c_void_p, c_wchar_p
from pathlib import Path

assert sys.platform == "win32"  # noqa: S101 - for mypy, which then checks this file for Windows only

_KERNEL = ctypes.WinDLL("kernel32", use_last_error=True)
_FOREVER = 0xFFFFFFFF  # ms
_FREE, _ABANDONED = 0, 0x80  # what waiting for a lock returns; its process has ended without a release
_BETWEEN_LOOKS = 0.05  # s
_locked: set[tuple[str, int]] = set()  # names and the threads that hold them


class ResourceLimiter:
    """Ends this process, with an exit code, where it exceeds a limit: Windows has none for one process."""

    def __init__(self, memory: Callable[[], int], overtime: int, out_of_memory: int) -> None:
        self._memory, self._overtime, self._out_of_memory = memory, overtime, out_of_memory
        self._until = self._most = float("inf")
        self._started = False

    def limit(self, *, seconds: float | None = None, memory: int | None = None) -> None:
        """Allow so much processor time from now on, or so many further bytes."""
        if seconds is not None:
            self._until = time.process_time() + seconds
        if memory is not None:
            self._most = self._memory() + memory
        if not self._started:
            self._started = True
            threading.Thread(target=self._look, daemon=True, name="limits").start()

    def _look(self) -> None:
        while True:
            time.sleep(_BETWEEN_LOOKS)
            if time.process_time() > self._until:
                os._exit(self._overtime)
            if self._memory() > self._most:
                os._exit(self._out_of_memory)


class WindowsPathLock:
    """The lock of a file or directory, by a name that all processes of a session of Windows know.

    The system frees it when the process ends. Windows would give a thread a lock twice, hence the names.
    """

    def __init__(self, path: Path) -> None:
        name = str(path.resolve()).casefold()
        self._name = "Local\\conrod-fea-" + hashlib.sha256(name.encode()).hexdigest()
        self._handle: int | None = None

    def take(self, *, wait: bool) -> bool:
        """Take the lock; False where it is held."""
        if (self._name, threading.get_ident()) in _locked:
            return False
        create, wait_for = _KERNEL.CreateMutexW, _KERNEL.WaitForSingleObject
        create.argtypes, create.restype = (c_void_p, c_uint32, c_wchar_p), c_void_p
        wait_for.argtypes = (c_void_p, c_uint32)
        handle = create(None, 0, self._name)
        if not handle:
            return False
        if wait_for(handle, _FOREVER if wait else 0) not in (_FREE, _ABANDONED):
            _KERNEL.CloseHandle(c_void_p(handle))
            return False
        self._handle = handle
        _locked.add((self._name, threading.get_ident()))
        return True

    def release(self) -> None:
        """Give the lock back, in the thread that took it."""
        _locked.discard((self._name, threading.get_ident()))
        _KERNEL.ReleaseMutex(c_void_p(self._handle))
        _KERNEL.CloseHandle(c_void_p(self._handle))
