"""The signals that ask a program to end: all are handled like Ctrl-C, with a clean-up."""

import signal
import threading
import time

from geometry.system.signals import ENDS

_CALM = 1.0  # seconds during which further signals are ignored


def interrupt_once(*, afresh: bool = False) -> None:
    """Raise `KeyboardInterrupt` at any of them; a quick succession of signals counts as one.

    A signal that is ignored (`nohup`) or that a host program handles is left as it is. Threads other than the
    main one receive no signals and are left alone.

    Parameters
    ----------
    afresh
        Replace whatever handles the signals now, such as the handlers set while the program starts.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    last = -_CALM

    def interrupt(_number: int, _frame: object) -> None:
        nonlocal last
        since, last = time.monotonic() - last, time.monotonic()
        if since >= _CALM:
            raise KeyboardInterrupt

    for number in ENDS:
        handler = signal.getsignal(number)
        ours = handler in (signal.default_int_handler, signal.SIG_DFL)
        if ours or (afresh and handler is not signal.SIG_IGN):
            signal.signal(number, interrupt)
