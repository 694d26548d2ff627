"""Loads drawn at random, on rods that are."""

import dataclasses

import numpy as np

from fea.base.choices import Support
from fea.study.option_tables import AnalysisTable, ForcesTable
from fea.study.speed_tables import SpeedTable
from fea.study.study import Study

PRESSURES = ("cosine-180", "cosine-120", "uniform-120", "webster")
GASES = ("otto", "motored", "none")
CLAMPED_SHARE = 0.25


def randomly_loaded(study: Study, seed: int, *, in_contact: bool = False) -> Study:
    """The rod of a study under other loads: a given pin force with the big end clamped, or another engine.

    Parameters
    ----------
    study
        Of a random rod, with an engine and dimensions.
    seed
        The same seed draws the same loads.
    in_contact
        Whether an engine presses by pins in contact, the default, and not by a pressure that is drawn.
    """
    draw = np.random.default_rng([seed, 23])
    pressure = str(draw.choice(PRESSURES))
    if draw.random() < CLAMPED_SHARE:
        rod = study.rod.dimensions
        axial = 30.0 * rod.small_end_bore * rod.small_end_width * draw.choice([-1, 1])  # 30 MPa on the bore
        across = abs(axial) * draw.uniform(-0.2, 0.2)
        clamped = AnalysisTable(support=Support.CLAMPED, pressure=pressure)
        forces = ForcesTable((float(axial), float(across)))
        return dataclasses.replace(study, engine=None, forces=forces, analysis=clamped)
    engine, rpm = study.engine, study.speed.speeds()[0]
    engine = dataclasses.replace(
        engine,
        gas=str(draw.choice(GASES)),
        piston_mass_kg=float(engine.piston_mass_kg * np.exp(draw.normal(0, 0.5))),
        pin_offset_mm=float(engine.stroke_mm * draw.uniform(-0.03, 0.03)),
        friction=float(draw.uniform(0, 0.1)),
    )
    if engine.gas == "none":
        engine = dataclasses.replace(engine, compression_ratio=None)
    if engine.gas != "otto":
        engine = dataclasses.replace(engine, peak_pressure_bar=None)
    speed = SpeedTable(rpm=float(rpm * draw.uniform(0.3, 1.2)))
    analysis = AnalysisTable(pressure=None if in_contact else pressure)
    return dataclasses.replace(study, engine=engine, speed=speed, analysis=analysis)
