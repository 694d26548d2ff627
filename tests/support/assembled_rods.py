"""Studies of rods in parts."""

import dataclasses

from assemblies import BOLTED

from fea.study.assembly_table import AssemblyTable
from fea.study.flags import Flags
from fea.study.speed_tables import SpeedTable
from fea.study.study import load_study

EVERY = AssemblyTable(
    bolt_preload_kN=30.0,
    bolt_nut_mm=13.0,
    bushing_interference_mm=0.03,
    shell_thickness_mm=1.5,
    shell_interference_mm=0.03,
)


def study(table=EVERY, rpm=6000.0, rod=BOLTED, **flags):
    """León's rod with a cap, bolts, a bushing and shells."""
    given = load_study("leon-2001")
    given = dataclasses.replace(given, rod=dataclasses.replace(given.rod, dimensions=rod))
    given = Flags(pressure="contact", **flags).applied(given)
    return dataclasses.replace(given, speed=SpeedTable(rpm), assembly=table)
