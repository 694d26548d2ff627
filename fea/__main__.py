"""The program: `fea`, which is also `python -m fea`."""

import atexit
import contextlib
import gc
import os
import signal
import sys

_INTERRUPTED = 130  # as in fea.machine.exit_codes; nothing of ours is imported before interrupts are quiet
_SAID = "fea: interrupted; no incomplete result was left behind\n"


def main() -> None:
    """Run the program and leave with its exit code."""
    _end_quietly()
    from fea.machine.guard import guarded  # noqa: PLC0415 - an interrupt of the import has its exit code too
    from fea.machine.streams import settle_streams  # noqa: PLC0415

    settle_streams()
    code = guarded(_called)
    if code == _INTERRUPTED:  # Python would end by the signal where an `exec` was interrupted, handled or not
        atexit._run_exitfuncs()  # noqa: SLF001 - the files of a pool of processes go
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    _end_quietly()
    gc.freeze()  # what the libraries leave in cycles need not be searched: it ends with the process
    sys.exit(code)


def _end_quietly() -> None:
    """Let a signal end the program at once while there is nothing to clean up."""

    def end(_number: int, _frame: object) -> None:
        with contextlib.suppress(OSError):
            os.write(2, _SAID.encode())
        os._exit(_INTERRUPTED)

    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, end)


def _called() -> int:
    """Run the command line; report errors that occur before it is loaded."""
    try:
        from fea.machine.exit_codes import MACHINE  # noqa: PLC0415 - as above
        from geometry.system import interrupt_once  # noqa: PLC0415

        interrupt_once(afresh=True)
        from fea.cli.program import call  # noqa: PLC0415
    except KeyboardInterrupt:
        sys.stderr.write(_SAID)
        return _INTERRUPTED
    except Exception as error:
        if os.environ.get("FEA_DEBUG") == "1":
            raise
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        sys.stderr.write(f"fea: the program could not be loaded: {reason}\n")
        return MACHINE
    return call(sys.argv[1:])


if __name__ == "__main__":
    main()
