"""Where the runs of a study belong: a folder each speed, and the file of its animation."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from fea.output.folder import require_replaceable
from fea.study.study import Study
from geometry.errors import require


class Place(NamedTuple):
    """Where a speed's run belongs: speed in rpm, folder, and file of its animation."""

    rpm: float | None
    folder: Path
    film: Path | None


def places_of(study: Study) -> list[Place]:
    """Return the place of each speed's run, where it may be written.

    Raises `InvalidValue`: an animation cannot be written, or is requested without the cycle; `OccupiedError`,
    `StorageError`: the output directory cannot take the run.
    """
    speeds = study.speeds()
    folders = _folders(study, speeds)
    places = [Place(rpm, folder, _film(study, rpm)) for rpm, folder in zip(speeds, folders, strict=True)]
    require_replaceable(target_of(places))
    for film in (place.film for place in places if place.film is not None):
        from fea.output.pictures.animation import require_film  # noqa: PLC0415 - only a film needs it

        require_film(film)
    return places


def target_of(places: Sequence[Place]) -> Path:
    """Return the directory that is replaced as a whole: a run's own, or the one above several."""
    return places[0].folder if len(places) == 1 else places[0].folder.parent


def _folders(study: Study, speeds: Sequence[float | None]) -> list[Path]:
    given = study.output.directory
    if len(speeds) == 1:
        name = study.name if speeds[0] is None else f"{study.name}-{speeds[0]:g}rpm"
        return [Path("results") / name if given is None else study.folder / given]
    parent = Path("results") / study.name if given is None else study.folder / given
    return [parent / f"{rpm:g}rpm" for rpm in speeds]


def _film(study: Study, rpm: float | None) -> Path | None:
    if study.output.animate is None:
        return None
    rule = "has no effect without the crank cycle"
    require(study.analysis.cycle, "--animate", study.output.animate, rule, "Add --cycle.")
    path = study.folder / study.output.animate
    speeds = study.speeds()
    return path if len(speeds) == 1 else path.with_stem(f"{path.stem}-{rpm:g}rpm")
