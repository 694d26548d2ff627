"""León's bore: 76 mm is printed twice, 82.3 and 87 mm are implied elsewhere; effect of each on the loads."""

from dataclasses import dataclass

from fea.study.traces import shipped_trace
from fea.units import DEG, RPM
from fea.verify.reproduce.leon_engine import ROD, SOURCE, SPEEDS, engine
from loads.cases import peak_cases
from loads.crank_cycle import CrankCycle

# As printed, from the two litres of the engine, and from the piston area of table 7.
BORES = (76.0, 82.3, 87.0)


@dataclass(frozen=True)
class PeakLoad:
    """A peak case with one of the bores: axial force at the worse end of the rod, N, tension positive."""

    bore: float
    rpm: int
    case: str
    crank_deg: float
    axial: float
    wall: float


def bore_sensitivity() -> list[PeakLoad]:
    """Find the peak cases of every bore and speed."""
    found = []
    for rpm in SPEEDS:
        for bore in BORES:
            for case in peak_cases(CrankCycle(engine(bore), ROD, shipped_trace(SOURCE), rpm * RPM)).cases:
                if case.name in {"tension", "compression", "side"}:
                    axial = max(float(case.pin_axial), float(case.crank_axial), key=abs)
                    angle = float(case.crank_angle) / DEG
                    found.append(PeakLoad(bore, rpm, case.name, angle, axial, float(case.wall)))
    return found
