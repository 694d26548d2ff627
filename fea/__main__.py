"""The program: `fea`, which is also `python -m fea`."""

import os
import sys

from fea.machine.guard import MACHINE, guarded
from fea.machine.streams import settle_streams

_INTERRUPTED = 130


def main() -> None:
    """Run the program and leave with its exit code."""
    settle_streams()
    code = guarded(_called)
    if code == _INTERRUPTED:  # Python would end by the signal where an `exec` was interrupted, handled or not
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    sys.exit(code)


def _called() -> int:
    """Run the command line; what goes wrong before it can speak is told here."""
    try:
        from fea.cli import call  # noqa: PLC0415 - an interrupt of the import has its exit code too
    except KeyboardInterrupt:
        sys.stderr.write("fea: interrupted; nothing was left half-written\n")
        return _INTERRUPTED
    except Exception as error:
        if os.environ.get("FEA_DEBUG") == "1":
            raise
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        sys.__stderr__.write(f"fea: the program could not be loaded: {reason}\n")  # type: ignore[union-attr]
        return MACHINE
    return call(sys.argv[1:])


if __name__ == "__main__":
    main()
