"""Studies of rods in parts, drawn at random."""

import dataclasses

import numpy as np
from rod_studies import random_study

from fea.base.choices import CONTACT, PinBody
from fea.study.assembly_table import AssemblyTable
from fea.study.option_tables import AnalysisTable, ContactTable, MeshTable
from fea.study.speed_tables import SpeedTable
from fea.study.study import Study
from geometry.errors import InvalidValue
from mesh.sizing import default_size


def assembled_study(seed: int) -> Study | InvalidValue | None:
    """A random assembled rod on a coarse mesh, or its refusal; None where no rod or no bolts were drawn."""
    study = random_study(seed)
    if study is None or not study.rod.dimensions.cap_bolt:
        return None
    draw, rod = np.random.default_rng([seed, 191]), study.rod.dimensions
    head = rod.cap_bolt * float(draw.uniform(1.35, 1.7))

    def some(chance: float, value: float) -> float | None:
        return float(value) if draw.random() < chance else None

    shell = some(0.6, draw.uniform(0.1, 0.4) * rod.big_end_ring)
    try:
        wider = dataclasses.replace(
            rod, cap_bolt_spacing=rod.cap_bolt_spacing + head * draw.uniform(0.3, 1.0)
        )
        table = AssemblyTable(
            bolt_preload_kN=float(0.35 * rod.cap_bolt**2 * draw.uniform(0.3, 1.3)),
            bolt_head_mm=head,
            bolt_nut_mm=some(0.5, head * draw.uniform(0.85, 1.05)),
            bushing_interference_mm=some(0.7, 1.5e-3 * rod.small_end_bore * draw.random())
            if rod.bushing
            else None,
            shell_thickness_mm=shell,
            shell_interference_mm=None
            if shell is None
            else some(0.8, 1.2e-3 * rod.big_end_bore * draw.random()),
            joint_friction=some(0.8, draw.choice([0.0, 0.05, 0.15, 0.3, 0.6])),
            temperature_C=some(0.5, draw.uniform(-20, 160)),
        )
        return dataclasses.replace(
            study,
            rod=dataclasses.replace(study.rod, dimensions=wider),
            assembly=table,
            contact=ContactTable(piston_pin=PinBody(draw.choice(["elastic", "rigid"]))),
            analysis=AnalysisTable(pressure=CONTACT),
            mesh=MeshTable(size_mm=float(2 * default_size(rod.length))),
            speed=SpeedTable(float(study.speed.speeds()[0] * draw.uniform(0.2, 1.3))),
        )
    except InvalidValue as refusal:
        return refusal
