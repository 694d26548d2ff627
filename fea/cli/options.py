"""Shared by several commands: a study with its flags, other options, and printing."""

import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, make_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from cyclopts import Parameter

from fea.base.choices import UnitSystem
from fea.machine.threads import limit_threads
from fea.output.units import shown_in

if TYPE_CHECKING:
    from fea.study.flags import Flags
    from fea.study.study import Study

Command = TypeVar("Command", bound=Callable[..., Any])

StudyName = Annotated[
    str, Parameter(help="A shipped study (leon-2001, columba-2022, molina-2024, …) or a TOML file.")
]
Threads = Annotated[int | None, Parameter(help="Number of solver threads; default: all processors.")]
Json = Annotated[bool, Parameter(help="Print the figures as JSON and nothing else.")]
Quiet = Annotated[bool, Parameter(help="Print nothing.")]
Verbose = Annotated[
    bool, Parameter(help="Print everything: all tables, assumptions, notes and the list of files.")
]
Markdown = Annotated[
    Path | None,
    Parameter(
        name=["--report", "--out"],
        help="Write a Markdown report to this file (.md), with its plots next to it.",
    ),
]


@dataclass(frozen=True)
class Printed:
    """How figures are printed."""

    json: Json = False
    quiet: Quiet = False

    @property
    def silent(self) -> bool:
        """Whether no progress is shown."""
        return self.json or self.quiet

    def show(
        self,
        figures: object,
        table: Callable[[], object],
        study: "Study | None" = None,
        written: Iterable[Path | None] = (),
        digits: int | None = None,
    ) -> None:
        """Print figures as JSON, with so many significant digits, or their table, in the units of a study.

        After the table come the files that were written.
        """
        if self.json:
            print_json(figures, digits)
        elif not self.quiet:
            with shown_in(UnitSystem.SI if study is None else study.output.units):
                table()
            print_written(written)


Printing = Annotated[Printed, Parameter(name="*")]
USUAL = Printed()
# Flags that say how the file of a rod is read.
FILE_FLAGS = ("unit", "solids", "cap", "big_end_bore", "small_end_bore", "swap_ends")


def takes(*names: str, **helps: str) -> Callable[[Command], Command]:
    """Give a command flags of a study, by their `names`, as the fields of its parameter `flags`.

    ``unusual`` is among them always, and without names all are. `helps`: the help of more flags, where it is
    not that of `fea run`.
    """
    from fea.study.flags import Flags, overrides

    all_flags = overrides()
    fields = []
    for name in (*names, *helps, "unusual") if names or helps else all_flags:
        flag = all_flags[name]
        hint, alias = flag.kind if flag.kind is bool else flag.kind | None, flag.declared.alias
        negative = f"--no-{name}" if flag.may_be_false else ""
        parameter = Parameter(help=helps.get(name, flag.help), negative=negative)
        fields.append((name, Annotated[hint, parameter], field(default=None)))
        if alias:
            fields.append((alias, Annotated[hint, Parameter(show=False)], field(default=None)))

    def decorated(command: Command) -> Command:
        chosen = make_dataclass("Flags", fields, bases=(Flags,), namespace={"__module__": __name__})
        command.__annotations__["flags"] = Annotated[chosen, Parameter(name="*")]
        return command

    return decorated


def load_with_flags(study: str, flags: "Flags", threads: int | None = None) -> "Study":
    """Return a study with its flags; before that, and before a library starts threads, they are limited."""
    from fea.study.study import load_study

    limit_threads(threads)
    return flags.applied(load_study(study))


def print_json(value: object, digits: int | None = None) -> None:
    """Print figures as JSON, with so many significant digits."""
    from fea.output.json_file import DIGITS, json_text

    sys.stdout.write(json_text(value, DIGITS if digits is None else digits))


def one_or_all(values: list[Any]) -> Any:
    """Return the only value, or all of them: the figures of one speed are not a list."""
    return values[0] if len(values) == 1 else values


def print_written(paths: Iterable[Path | None]) -> None:
    """Name the files that were written."""
    for path in paths:
        if path is not None:
            sys.stdout.write(f"Wrote {path}\n")
