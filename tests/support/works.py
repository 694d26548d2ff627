"""Works for a process of their own."""

import os
import signal
import time

from fea.machine.isolated import say


def twice(number):
    return 2 * number


def fails():
    raise ValueError("no figure")


def tells():
    say("at work")
    return os.getpid()


def dies():
    if os.name != "posix":
        os._exit(0xC0000005 - 2**32)  # as Windows ends a process that reads where nothing is
    os.kill(os.getpid(), signal.SIGKILL)


def asks_its_parent_to_end(path, parent):
    """Wait, and say on the way out that there was time to clean up."""
    try:
        os.kill(parent, signal.SIGTERM)
        time.sleep(60)
    finally:
        path.write_text("cleaned up")


def waits(path):
    """Say who waits."""
    path.with_suffix(".begun").write_text(str(os.getpid()))
    path.with_suffix(".begun").replace(path)
    time.sleep(60)
