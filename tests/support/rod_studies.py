"""Studies of rods and engines drawn at random."""

import numpy as np
from rods import random_rod

from fea.study.engine_table import EngineTable
from fea.study.rod_table import RodTable
from fea.study.speed_tables import SpeedTable
from fea.study.study import Study
from geometry.dimensions import ShankSection
from geometry.errors import InvalidValue
from geometry.rod import Rod


def random_study(seed: int, section: ShankSection | None = None) -> Study | None:
    """A random rod in a random engine at full speed; None where the rod is refused."""
    rod = random_rod(seed, section)
    return None if isinstance(rod, InvalidValue) else random_engine(seed, rod)


def random_engine(seed: int, rod: Rod) -> Study:
    """A rod in a random engine at full speed."""
    draw = np.random.default_rng(10_000 + seed)
    stroke = rod.length * draw.uniform(0.45, 0.75)
    bore = stroke * draw.uniform(0.8, 1.2)
    speed = draw.uniform(8, 20) * 30 / (stroke * 1e-3)  # from the mean piston speed, m/s
    engine = EngineTable(
        stroke_mm=float(stroke),
        bore_mm=float(bore),
        piston_mass_kg=float(1.2 * (bore / 86) ** 3 * draw.uniform(0.5, 1.0)),
        cylinders=4,
        gas="otto",
        compression_ratio=10.0,
        peak_pressure_bar=float(draw.uniform(50, 110)),
    )
    table = RodTable(rod, None, None, rod.length)
    return Study(f"random-{seed}", table, engine=engine, speed=SpeedTable(rpm=float(speed)))
