"""`fea view`."""

from pathlib import Path

from rich.console import Console


def view(file: Path, *, field: str | None = None, out: Path | None = None) -> None:
    """Draw a result: a load case, the envelope of the crank cycle, or a mode; or open a report.

    Parameters
    ----------
    file
        The .vtu file of a run or of `fea modes`; or a report, report.html, which your browser opens.
    field
        Field to draw. Load case: von_mises, principal_1, principal_3, safety_factor or displacement;
        envelope.vtu: also mean, amplitude, fatigue_safety_factor or crossland_safety_factor; modes: mode_1,
        mode_2, …. Default: the first of these that the file has.
    out
        The .png file to write; default: next to the result.
    """
    if file.suffix.lower() == ".html":
        _open(file, field, out)
        return
    from fea.output.pictures.picture import picture_of
    from fea.output.target import require_target

    require_target("--out", out, (".png",))
    picture = picture_of(file, out or file.with_suffix(".png"), field)
    _say(f"Wrote {picture}")


def _open(file: Path, field: str | None, out: Path | None) -> None:
    """Open a report in the browser."""
    from fea.output.report.opening import open_report
    from geometry.invalid import require

    for option, value in (("--field", field), ("--out", out)):
        rule = "cannot be used with a report, which shows every field"
        require(value is None, option, None if value is None else str(value), rule, "Leave it out.")
    open_report(file)
    _say(f"Opened {file}")


def _say(text: str) -> None:
    Console(soft_wrap=True, highlight=False).print(text, markup=False)
