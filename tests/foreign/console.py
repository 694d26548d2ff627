"""Run `fea rod` in a console of Windows, by that system's Python, and save its screen as screen.txt."""

import ctypes
import msvcrt
import os
import subprocess
import sys
from ctypes import wintypes
from pathlib import Path

_KERNEL = ctypes.windll.kernel32
_WIDTH, _HEIGHT = 120, 300
_KERNEL.FreeConsole()
_KERNEL.AllocConsole()
console = os.open("CONOUT$", os.O_RDWR)
handle = wintypes.HANDLE(msvcrt.get_osfhandle(console))
_KERNEL.SetConsoleScreenBufferSize(handle, wintypes._COORD(_WIDTH, _HEIGHT))
streams = {"stdin": subprocess.DEVNULL, "stdout": console, "stderr": console}
subprocess.run([sys.executable, "-m", "fea", "rod"], check=True, **streams)
screen, count = ctypes.create_unicode_buffer(_WIDTH * _HEIGHT), wintypes.DWORD()
_KERNEL.ReadConsoleOutputCharacterW(handle, screen, len(screen), wintypes._COORD(0, 0), ctypes.byref(count))
text = screen[: count.value]
lines = [text[place : place + _WIDTH].rstrip() for place in range(0, len(text), _WIDTH)]
Path("screen.txt").write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")
