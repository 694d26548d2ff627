"""The signals that ask a program to end, each taken as Ctrl-C is: what is under way is cleaned up."""

import signal
import threading
import time

from geometry.system.signals import ENDS

_CALM = 1.0  # seconds from one to the next that counts


def interrupt_once(*, afresh: bool = False) -> None:
    """Raise `KeyboardInterrupt` at any of them; several in quick succession do not cut short its clean-up.

    One that is ignored (`nohup`) or that a host program handles is left so, as is a thread other than the
    main one, which gets none.

    Parameters
    ----------
    afresh
        In place of whatever handles them now: the program's own first moments did.
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
