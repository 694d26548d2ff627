"""Studies drawn at random over the input space, run, and their written results examined anew."""

import math
import tempfile
from pathlib import Path

import numpy as np
from recheck import Told, recheck
from rods import random_rod

EQUILIBRIUM, SECTION = 1e-6, 0.03


def outcome(seed):
    """What became of a study: refused, rechecked, marked (untrusted), or what must never be."""
    from fea import run
    from fea.cli import exit_code
    from fea.study.engine_table import EngineTable
    from fea.study.rod_table import RodTable
    from fea.study.study import MeshTable, SpeedTable, Study
    from geometry.invalid import InvalidValue

    rod = random_rod(seed)
    if isinstance(rod, InvalidValue):
        return {"outcome": "refused", "code": 2, "by": rod.name}
    draw = np.random.default_rng([seed, 7])
    ratio, rpm = draw.uniform(0.1, 0.9), float(draw.choice([0.0, 1.0, draw.uniform(100, 9000), 20_000.0]))
    stroke, bore = 2 * ratio * rod.length, rod.length * draw.uniform(0.3, 1.0)
    gas = draw.choice(["none", "otto", "motored"])
    otto = {"peak_pressure_bar": float(draw.uniform(30, 300))} if gas == "otto" else {}
    ratios = {} if gas == "none" else {"compression_ratio": 6.0}
    mass = 7700e-9 * 0.05 * bore**3
    try:
        engine = EngineTable(stroke, bore, mass, gas=str(gas), **otto, **ratios)
        table = RodTable(rod, None, None, rod.length)
        mesh = MeshTable(size_mm=rod.length / 18)
        study = Study("random", table, engine=engine, speed=SpeedTable(rpm), mesh=mesh)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "study.toml")
            path.write_text(study.text())
            figures = run(str(path), out=Path(folder, "r"))
            if not figures["trusted"]:
                failed = [name for name, check in figures["checks"].items() if not check["pass"]]
                return {"outcome": "marked", "code": 5, "by": ", ".join(failed)}
            told = Told(
                207e3, 0.28, 7700e-12, rod.big_end_bore / 2, rod.small_end_bore / 2, rod.length,
                stroke / 2, rpm * math.pi / 30,
            )  # fmt: skip
            equilibrium, section = recheck(Path(folder, "r"), figures, told)
    except Exception as error:  # noqa: BLE001 - a crash is a finding
        code = exit_code(error)
        kind = "crashed" if code is None else "refused"
        return {"outcome": kind, "code": code, "by": f"{type(error).__name__}: {error}"[:200]}
    good = equilibrium <= EQUILIBRIUM and section <= SECTION
    return {"outcome": "rechecked" if good else "WRONG", "equilibrium": equilibrium, "section": section}
