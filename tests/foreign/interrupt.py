"""Interrupt a run on Windows by Ctrl-C, by that system's Python: interrupt.py SECONDS.

Prints the exit code of the run, and the seconds it took after the interrupt.
"""

import ctypes
import json
import signal
import subprocess
import sys
import time

_KERNEL = ctypes.windll.kernel32
_KERNEL.FreeConsole()  # that of pipes gets no Ctrl-C
_KERNEL.AllocConsole()
_KERNEL.SetConsoleCtrlHandler(None, 0)  # what started this may ignore it
signal.signal(signal.SIGINT, lambda *_: None)
run = [sys.executable, "-m", "fea", "run", "--size", "4", "--quiet", "--out", "r"]
with subprocess.Popen(
    run, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
) as process:
    time.sleep(float(sys.argv[1]))
    early = process.poll()
    sent = _KERNEL.GenerateConsoleCtrlEvent(0, 0)
    start = time.monotonic()
    try:
        said = process.communicate(timeout=60)[0].decode("utf-8")
    except subprocess.TimeoutExpired:
        process.kill()
        said = "did not end"
found = {"code": process.returncode, "early": early, "seconds": time.monotonic() - start, "said": said}
sys.stdout.write(json.dumps(found | {"sent": sent}))
