"""`fea modes`."""

import sys
from pathlib import Path

from fea.machine.exit_codes import CHECK_FAILED
from fea.study.study import DEFAULT_STUDY


def modes(
    study: str = DEFAULT_STUDY,
    *,
    rpm: str | None = None,
    size: float | None = None,
    count: int = 6,
    vtu: Path | None = None,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Compute the free-free vibration modes and the engine orders that excite them.

    Parameters
    ----------
    study
        A shipped study (leon-2001, columba-2022, molina-2024, …) or a TOML file.
    rpm
        Engine speeds, rpm: one (6000), a list (800,3000,6000) or from:to:step (800:9000:200).
    size
        Element size, mm; default: 1/28 of the rod's length, smaller on fillets, bores and webs.
    count
        Number of elastic modes; the six rigid-body modes are not counted.
    vtu
        Write the mode shapes to this .vtu file, which `fea view` can draw.
    json
        Print the figures as JSON and nothing else.
    quiet
        Print nothing.
    """
    from fea.output.target import require_target
    from fea.run.modes import modes_report
    from fea.study.flags import Flags
    from fea.study.study import load_study

    require_target("--vtu", vtu, (".vtu",))
    report = modes_report(Flags(rpm=rpm, size=size).applied(load_study(study)), count)
    figures = report.figures()
    if vtu is not None:
        from fea.output.vtu import write_vtu

        write_vtu(vtu, report.mesh, report.shapes)
    if json:
        from fea.output.json_file import json_text

        sys.stdout.write(json_text(figures))
    elif not quiet:
        from fea.output.terminal.rod import print_modes

        print_modes(figures)
        if vtu is not None:
            sys.stdout.write(f"Wrote {vtu}\n")
    return 0 if report.trusted else CHECK_FAILED
