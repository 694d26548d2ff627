"""`fea bolts` and `fea compare`: what to choose, side by side."""

import re
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from fea.cli.options import FILE_FLAGS, USUAL, Printing, StudyName, Threads, load_with_flags, takes
from fea.judge.safety_factor import SurvivalAnswer
from fea.machine.clock import stages
from fea.machine.exit_codes import CHECK_FAILED, UNSAFE
from fea.machine.threads import limit_threads
from fea.output.target import near, require_target
from fea.output.units import shown_in
from fea.study.flags import NO_FLAGS, Flags
from fea.study.study import DEFAULT_STUDY

Materials = Annotated[list[str] | None, Parameter(consume_multiple=True)]
_LONGEST = 80  # characters of the names of studies in the name of a page


@takes(
    *("engine", "material", "size", "tolerance", "units", *FILE_FLAGS),
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


@takes("cycle", "engine", "film", "min_safety", "pressure", "rpm", "size", "tolerance", "units")
def compare(
    *studies: str,
    flags: Flags = NO_FLAGS,
    material: Materials = None,
    same: bool = False,
    limits: bool = False,
    out: Path | None = None,
    threads: Threads = None,
    printing: Printing = USUAL,
) -> int:
    """Compare two to six studies, or one study in several materials: what differs, and what that does.

    Parameters
    ----------
    studies
        Shipped studies or TOML files; each is run at its highest speed.
    material
        Two to six materials in which one study is compared.
    same
        Judge all by the engine, speed, pins, film and mesh settings of the first study.
    limits
        Find the highest speed and peak pressure of each, too; it takes some minutes.
    out
        The page to write (.html); default: results/compare-NAMES.html.
    """
    require_target("--out", out, (".html",), parents=True)
    limit_threads(threads)

    from fea.apps.compare.run_compare import compare as compared
    from fea.apps.compare.run_compare import named_studies
    from fea.apps.compare.tables import print_comparison, write_page

    loaded = [flags.applied(study) for study in named_studies(studies, material or ())]
    if out is None:
        names = "-".join(study.name for study in loaded)
        out = Path("results") / f"compare-{re.sub(r'[^A-Za-z0-9.]+', '-', names)[:_LONGEST]}.html"
    with stages(silent=printing.silent) as listener:
        found = compared(loaded, listener, alike=same, limits=limits)
    with shown_in(loaded[0].output.units):
        write_page(out, found)
    printing.show(found, lambda: print_comparison(found), loaded[0], (near(out),))
    answers = {SurvivalAnswer(one.summary.survival.answer) for one in found.designs}
    if not found.trusted:
        return CHECK_FAILED
    asked = any(study.analysis.min_safety is not None for study in loaded)
    return UNSAFE if asked and answers & {SurvivalAnswer.FAILS, SurvivalAnswer.UNDECIDED} else 0
