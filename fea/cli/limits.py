"""`fea limits`."""

from pathlib import Path
from typing import TYPE_CHECKING

from fea.cli.options import FILE_FLAGS, USUAL, Printing, StudyName, Threads, asked_for, takes
from fea.machine.exit_codes import CHECK_FAILED, UNSAFE
from fea.study.flags import NO_FLAGS, Flags
from fea.study.study import DEFAULT_STUDY
from fea.study.tables import number_of
from geometry.errors import require_number, require_positive

if TYPE_CHECKING:
    from fea.apps.limits.figures import LimitsFigures


@takes(
    "engine",
    "film",
    "material",
    "pressure",
    "size",
    "tolerance",
    "units",
    *FILE_FLAGS,
    min_safety="Required safety factor; default: that of the study, or 1.",
    rpm="Operating speeds, rpm; the largest peak pressure is found at the highest.",
)
def limits(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    min_rpm: float | str | None = None,
    min_boost: float | str | None = None,
    duty: bool = False,
    out: Path | None = None,
    threads: Threads = None,
    printing: Printing = USUAL,
) -> int:
    """Find the highest speed and peak pressure that a rod survives, and how it fails beyond.

    Parameters
    ----------
    min_rpm
        Speed, in rpm or with its unit, that the rod must reach at the study's load, less the error bar;
        otherwise exit code 6.
    min_boost
        Boost, in bar or with its unit, that it must survive at this speed, less the error bar; otherwise
        exit code 6.
    duty
        Compute the hours of life at each point as well, as with [duty] in the study; needs an S-N line.
    out
        Directory of the results; default: results/STUDY-limits. Only an earlier run is ever replaced.
    """
    asked = asked_for(study, flags, threads)
    least_rpm = number_of("--min-rpm", min_rpm, "rpm")
    least_boost = number_of("--min-boost", min_boost, "boost_bar")
    if min_rpm is not None:
        require_positive("--min-rpm", least_rpm)
    if min_boost is not None:
        require_number("--min-boost", least_boost)

    from fea.apps.limits.run_limits import limits as find_limits
    from fea.machine.clock import stages
    from fea.output.units import shown_in

    folder = Path("results") / f"{asked.name}-limits" if out is None else out
    with shown_in(asked.output.units), stages(silent=printing.silent) as listener:
        figures = find_limits(asked, folder, listener, at_rpm=least_rpm, duty=duty)
    reached = figures.reaches(least_rpm, least_boost)
    printing.show(figures, lambda: _print(figures, folder, reached=reached), asked)
    if not figures.trusted:
        return CHECK_FAILED
    return 0 if reached else UNSAFE


def _print(figures: "LimitsFigures", folder: Path, *, reached: bool) -> None:
    from fea.apps.limits.figures import TABLE_HEAD
    from fea.output.target import near
    from fea.output.terminal.prose import print_lines, terminal
    from fea.output.units import in_heading, in_rows

    short = "It does not reach what --min-rpm and --min-boost ask for, less the error bar: exit code 6."
    lines = [figures.text, *([] if reached else [short]), ""]
    if figures.table:
        rows = (map(in_heading, TABLE_HEAD), *in_rows(TABLE_HEAD, figures.table))
        lines += [f"{rpm:>6}  {safe:<24} {mode}" for rpm, safe, mode in rows]
        lines += [""]
    lines += [str(note) for note in figures.notes[:6]]
    lines += [f"Written to {near(folder)} ({len(figures.files)} files): {', '.join(figures.files)}."]
    print_lines(terminal(), lines)
