"""The command line: commands by name, errors as one line, exit codes."""

import os
import signal
import sys
import threading
import time
from collections.abc import Sequence
from importlib.metadata import version

from cyclopts import App, CycloptsError, Parameter, UnusedCliTokensError
from rich.console import Console

app = App(
    name="fea",
    help="Will this connecting rod survive this engine at this speed, where does it fail first, "
    "and how far can the answer be trusted?\n\n"
    "Exit codes: 0 done, 2 wrong usage or study, 3 no solid or mesh, 4 under-constrained or singular, "
    "5 not to be trusted, 6 below --min-safety, 7 this machine cannot, 130 interrupted.",
    version=lambda: version("conrod-fea"),
    default_parameter=Parameter(negative=""),
    suppress_keyboard_interrupt=False,  # ours has a message
)

# Each command lives in a module of its own, loaded when it is called.
_COMMANDS = {
    "run": "Analyse a rod: stresses and safety factors at the peaks of the crank cycle.",
    "loads": "Forces over the crank cycle, without a mesh.",
    "modes": "Free vibration of the free rod, against the orders of the speed.",
    "rod": "The solid: mass properties and sections, STEP export, a picture.",
    "reproduce": "Published figures against computed ones.",
    "verify": "Benchmark problems with known answers.",
    "converge": "Error against run time, for a rod and two exact problems.",
    "stability": "Stiff and extreme cases: each right, marked or refused.",
    "view": "A picture of a result.",
    "init": "Write a commented study to edit.",
    "doctor": "What this machine can and cannot do.",
}
for _name, _help in _COMMANDS.items():
    app.command(f"fea.commands.{_name}:{_name}", name=_name, help=_help)

_LONGEST_MESSAGE = 1500
_CALM = 1.0  # seconds from one Ctrl-C to the next that counts
USAGE, GEOMETRY, SINGULAR, MACHINE, INTERRUPTED = 2, 3, 4, 7, 130


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the program and leave with its exit code."""
    sys.exit(call(sys.argv[1:] if arguments is None else arguments))


def call(arguments: Sequence[str]) -> int:
    """Run the program and return its exit code."""
    _interrupt_once()
    if os.environ.get("FEA_DEBUG") == "1":
        return _dispatch(arguments)
    try:
        return _dispatch(arguments)
    except KeyboardInterrupt:
        _say("interrupted; nothing was left half-written")
        return INTERRUPTED
    except Exception as error:  # noqa: BLE001 - every error becomes one line and a code
        code = MACHINE if "bad_alloc" in str(error) else exit_code(error)  # C++ for: no memory
        if code is None:
            _say(f"internal error: {type(error).__name__}: {error}. Run again with FEA_DEBUG=1 and report it")
            return 1
        _say(_text(error))
        return code


def _interrupt_once() -> None:
    """Take several Ctrl-C in quick succession as one, so that the others do not cut short its clean-up."""
    if threading.current_thread() is not threading.main_thread():
        return
    last = -_CALM

    def interrupt(_number: int, _frame: object) -> None:
        nonlocal last
        since, last = time.monotonic() - last, time.monotonic()
        if since >= _CALM:
            raise KeyboardInterrupt

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, interrupt)


def _dispatch(arguments: Sequence[str]) -> int:
    if not arguments:
        app.help_print([])
        return 0
    code = app(
        list(arguments),
        exit_on_error=False,
        print_error=False,
        result_action="return_value",
    )
    return code if isinstance(code, int) else 0


def exit_code(error: Exception) -> int | None:
    """Return the documented exit code of an error, None for one nobody foresaw."""
    from fea.output.errors import OccupiedError, OutputError
    from fea.solid.errors import (
        SingularMatrixError,
        SolverUnavailableError,
        StagnationError,
        UnderconstrainedError,
    )
    from geometry.errors import GeometryError
    from geometry.invalid import InvalidValue
    from mesh.errors import MeshError

    codes: dict[int, tuple[type[Exception], ...]] = {
        USAGE: (InvalidValue, CycloptsError, OccupiedError),
        GEOMETRY: (GeometryError, MeshError),
        SINGULAR: (UnderconstrainedError, SingularMatrixError, StagnationError),
        MACHINE: (SolverUnavailableError, OutputError, OSError, MemoryError, ImportError),
    }
    return next((code for code, kinds in codes.items() if isinstance(error, kinds)), None)


def _text(error: Exception) -> str:
    if isinstance(error, UnusedCliTokensError):
        more = " ".join(error.unused_tokens or [])
        return f"{more}: one argument too many. A command takes one study or file: see `fea --help`"
    return str(error) or type(error).__name__


def _say(message: str) -> None:
    text = "".join(letter if letter.isprintable() else "?" for letter in " ".join(message.split()))
    if len(text) > _LONGEST_MESSAGE:
        text = f"{text[: _LONGEST_MESSAGE // 2]} … {text[-_LONGEST_MESSAGE // 2 :]}"
    Console(stderr=True, highlight=False, soft_wrap=True).print(f"fea: {text}", markup=False)
