"""`fea modes`."""

from pathlib import Path

from fea.cli.options import DEFAULT_SIZE, Json, Quiet, StudyName, print_json, print_written, takes
from fea.machine.exit_codes import CHECK_FAILED
from fea.study.flags import NO_FLAGS, Flags
from fea.study.study import DEFAULT_STUDY, load_study


@takes("rpm", size=DEFAULT_SIZE)
def modes(
    study: StudyName = DEFAULT_STUDY,
    *,
    flags: Flags = NO_FLAGS,
    count: int = 6,
    vtu: Path | None = None,
    json: Json = False,
    quiet: Quiet = False,
) -> int:
    """Compute the free-free vibration modes and the engine orders that excite them.

    Parameters
    ----------
    count
        Number of elastic modes; the six rigid-body modes are not counted.
    vtu
        Write the mode shapes to this .vtu file, which `fea view` can draw.
    """
    from fea.output.target import require_target
    from fea.run.modes import modes_report

    require_target("--vtu", vtu, (".vtu",))
    report = modes_report(flags.applied(load_study(study)), count)
    figures = report.figures()
    if vtu is not None:
        from fea.output.vtu import write_vtu

        write_vtu(vtu, report.mesh, report.shapes)
    if json:
        print_json(figures)
    elif not quiet:
        from fea.output.terminal.rod import print_modes

        print_modes(figures)
        print_written((vtu,))
    return 0 if report.trusted else CHECK_FAILED
