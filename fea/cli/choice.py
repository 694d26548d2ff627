"""`fea bolts` and `fea compare`: what to choose, side by side."""

from pathlib import Path

from fea.cli.options import FILE_FLAGS, USUAL, Printing, StudyName, Threads, load_with_flags, takes
from fea.machine.clock import stages
from fea.machine.exit_codes import CHECK_FAILED
from fea.output.target import near, require_target
from fea.output.units import shown_in
from fea.study.flags import NO_FLAGS, Flags
from fea.study.study import DEFAULT_STUDY


@takes(
    "engine",
    "material",
    "size",
    "tolerance",
    "units",
    *FILE_FLAGS,
    rpm="Engine speed at which the bolts are judged; of several the highest.",
)
def bolts(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    out: Path | None = None,
    threads: Threads = None,
    printing: Printing = USUAL,
) -> int:
    """Compare the bolts that fit a rod: preload, torque, stretch, and how the joint holds.

    Parameters
    ----------
    out
        A file for the table (.csv) or for all figures (.json).
    """
    require_target("--out", out, (".csv", ".json"))
    loaded = load_with_flags(study, flags, threads)

    from fea.apps.bolts.printed import print_bolts, write_bolts
    from fea.apps.bolts.run_bolts import bolts as compared

    with stages(silent=printing.silent) as listener:
        found = compared(loaded, listener)
    if out is not None:
        write_bolts(out, found)
    printing.show(found.rows, lambda: print_bolts(found), loaded, () if out is None else (near(out),))
    return 0 if found.trusted else CHECK_FAILED
