"""The program: `fea`, which is also `python -m fea`. Commands, errors as one line, exit codes."""

import atexit
import contextlib
import gc
import os
import signal
import sys
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from cyclopts import App

_INTERRUPTED = 130  # as in fea.machine.exit_codes; nothing of ours is imported before interrupts are quiet
_SAID = "fea: interrupted; no incomplete result was left behind\n"
_LONGEST_MESSAGE = 1500


def main() -> None:
    """Run the program and leave with its exit code."""
    _end_quietly()
    try:
        from fea.machine.program import guarded, settle_streams  # their interrupts have their exit code, too
    except ImportError as error:
        sys.exit(_not_loaded(error))

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

    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, end)


def _called() -> int:
    try:
        from fea.machine.system import end_in_time, interrupt_once

        interrupt_once(afresh=True)
        end_in_time(_INTERRUPTED)
        program()
    except KeyboardInterrupt:
        sys.stderr.write(_SAID)
        return _INTERRUPTED
    except Exception as error:
        if os.environ.get("FEA_DEBUG") == "1":
            raise
        return _not_loaded(error)
    return call(sys.argv[1:])


def _not_loaded(error: Exception) -> int:
    from fea.machine.exit_codes import MACHINE
    from fea.machine.remedies import foreign_package

    reason = foreign_package(error) or " ".join(f"{type(error).__name__}: {error}".split())
    sys.stderr.write(f"fea: the program could not be loaded: {reason}\n")
    return MACHINE


@cache
def commands() -> dict[str, dict[str, str]]:
    """Return what is declared of each command, by its name."""
    import tomllib
    from pathlib import Path

    return tomllib.loads(Path(__file__).with_name("commands.toml").read_text(encoding="utf-8"))


@cache
def program() -> "App":
    """Return the command line; the module of a command is loaded when it is called."""
    from cyclopts import App, Parameter

    app = App(
        name="fea",
        help="Will this connecting rod survive this engine at this speed, where does it fail first, "
        "and how far can the answer be trusted?\n\n"
        "Exit codes: 0 done; 2 wrong usage or study; 3 no solid or no usable mesh; 4 under-constrained or "
        "singular system; 5 a check failed, do not trust the result; 6 a safety factor is below "
        "--min-safety; 7 not possible on this machine (disk, permission, memory, library); 130 interrupted.",
        version=_version,
        default_parameter=Parameter(negative="", show_default=_shown_default),
        suppress_keyboard_interrupt=False,  # handled below, with a message
    )
    for name, told in commands().items():
        app.command(
            f"fea.cli.{told.get('module', name)}:{name}",
            name=name,
            help=f"{told['help']}\n\nManual: docs/{told.get('page', 'reference/commands')}.md",
        )
    app.register_install_completion_command(help="Install completion of commands and flags for your shell.")
    return app


def _version() -> str:
    from fea.base.version import __version__

    return __version__


def _shown_default(value: object) -> Any:
    """Return a default as the help shows it; for a switch that is off, nothing is shown."""
    if value is None or value is False:
        return None
    return f"{value:g}" if isinstance(value, float) else str(value)


def call(arguments: Sequence[str]) -> int:
    """Run the program and return its exit code."""
    from fea.machine.exit_codes import INTERRUPTED, MACHINE
    from fea.machine.system import AtInterrupt, interrupt_once

    interrupt_once()
    if os.environ.get("FEA_DEBUG") == "1":
        return _dispatch(arguments)
    try:
        return _dispatch(arguments)
    except (KeyboardInterrupt, Exception) as error:  # noqa: BLE001 - every error becomes one line and a code
        if AtInterrupt.came or isinstance(error, KeyboardInterrupt):
            _say(AtInterrupt.message)
            return INTERRUPTED
        from fea.machine.remedies import foreign_package

        if said := foreign_package(error):
            _say(said)
            return MACHINE
        code = MACHINE if "bad_alloc" in str(error) else exit_code(error)  # C++: out of memory
        if code is None:
            what = f"internal error: {type(error).__name__}: {error}"
            _say(f"{what}. Run again with FEA_DEBUG=1 and report the traceback")
            return 1
        _say(_text(error))
        if example := getattr(error, "example", ""):
            sys.stderr.write(f"\n{example}")
        return code


def _dispatch(arguments: Sequence[str]) -> int:
    app = program()
    if not arguments:
        app.help_print([])
        return 0
    code = app(list(arguments), exit_on_error=False, print_error=False, result_action="return_value")
    sys.stdout.flush()  # fails on a full disk, so that the exit code is not 0
    return code if isinstance(code, int) else 0


def exit_code(error: Exception) -> int | None:
    """Return the documented exit code of an error, None for an unexpected error."""
    from cyclopts import CycloptsError

    from fea.machine.exit_codes import GEOMETRY, MACHINE, SINGULAR, USAGE
    from fea.output.folder import OccupiedError, OutputError
    from fea.solid.errors import (
        ContactError,
        SingularMatrixError,
        SolverUnavailableError,
        StagnationError,
        UnderconstrainedError,
    )
    from geometry.errors import GeometryError, InvalidValue
    from mesh.tetmesh import MeshError

    codes: dict[int, tuple[type[Exception], ...]] = {
        USAGE: (InvalidValue, CycloptsError, OccupiedError),
        GEOMETRY: (GeometryError, MeshError),
        SINGULAR: (UnderconstrainedError, SingularMatrixError, StagnationError, ContactError),
        MACHINE: (SolverUnavailableError, OutputError, OSError, MemoryError, ImportError),
    }
    return next((code for code, kinds in codes.items() if isinstance(error, kinds)), None)


def _text(error: Exception) -> str:
    from cyclopts import UnusedCliTokensError

    if isinstance(error, UnusedCliTokensError):
        more = " ".join(error.unused_tokens or [])
        return f"{more}: too many arguments. A command takes one study or file: see `fea COMMAND --help`"
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return str(error) or type(error).__name__


def _say(message: str) -> None:
    from rich.console import Console

    text = "".join(letter if letter.isprintable() else "?" for letter in " ".join(message.split()))
    if len(text) > _LONGEST_MESSAGE:
        text = f"{text[: _LONGEST_MESSAGE // 2]} … {text[-_LONGEST_MESSAGE // 2 :]}"
    Console(stderr=True, highlight=False, soft_wrap=True).print(f"fea: {text}", markup=False)


if __name__ == "__main__":
    main()
