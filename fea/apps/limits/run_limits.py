"""The job behind `fea limits`: the largest speed and peak pressure of a rod, and the map of both."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from fea.analysis.adapt import adapt_mesh
from fea.analysis.result import run_result
from fea.apps.limits.describe import figures_of, words
from fea.apps.limits.explore import Found, explore, limited_speeds
from fea.apps.limits.figures import LimitsFigures
from fea.apps.limits.files import FILES, LIFE, write_files
from fea.machine.clock import Clock
from fea.output.folder import require_replaceable, run_folder
from fea.study.study import Study, load_study
from geometry.errors import require_positive

# How the answer begins that is told before the map is made.
FIRST = "answer: "


def limits(
    study: Study | str | Path,
    folder: Path | None = None,
    listener: Callable[[str], None] | None = None,
    *,
    at_rpm: float | None = None,
    duty: bool = False,
) -> LimitsFigures:
    """Find how fast a rod can turn and how much peak pressure it stands.

    Parameters
    ----------
    study
        A study, a shipped one by name, or the path of a TOML file.
    folder
        Where the files go; None for none.
    listener
        Is told the name of each stage as it begins.
    at_rpm
        Speed at which the largest peak pressure is found; default: that of the study, the highest.
    duty
        Whether hours of life are found too; also with [duty] in the study.

    Raises
    ------
    InvalidValue
        There is no engine, or a value of the study breaks a rule.
    OccupiedError, StorageError
        The folder cannot take the files.
    GeometryError, MeshError, UnderconstrainedError, SingularMatrixError, ContactError
        The rod cannot be drawn, meshed or solved.
    """
    study = study if isinstance(study, Study) else load_study(study)
    speeds = limited_speeds(study)
    if at_rpm is not None:
        require_positive("at_rpm", at_rpm)
    if folder is not None:
        require_replaceable(folder)
    clock = Clock(listener)
    lasting = speeds if duty or study.duty is not None else []
    asked, study = study, replace(study, duty=None, analysis=replace(study.analysis, cycle=True))
    adapted = adapt_mesh(study, [speeds[-1]], clock)
    tell = listener or (lambda _text: None)

    def answered(first: Found) -> None:
        tell(FIRST + words(first))

    with clock("limits"):
        found = explore(adapted, speeds[-1], at_rpm, tell, answered, lasting=lasting)
    files = FILES if found.life is None else (*FILES, LIFE)
    figures = replace(figures_of(study, found, adapted, clock), files=files)
    if folder is not None:
        with run_folder(folder) as part:
            write_files(
                part, replace(run_result(study, adapted, found.static), study=asked), found, figures, speeds
            )
    return figures
