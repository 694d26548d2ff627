"""The [film] table: the oil of the big end's bearing, how it gets there, and the surfaces."""

from dataclasses import dataclass

from fea.study.tables import Table, key, not_negative, within
from geometry.errors import require_positive
from geometry.plausible import Plausible

# What is assumed where a study says nothing: hot engine oil, its inlet from the main bearings, a hole in the
# crank pin that leads the crank arm, run-in surfaces.
VISCOSITY_MPAS, PIEZOVISCOSITY_1_GPA = 8.0, 13.0
INLET_BAR, HOLE_DEG, HOLE_MM, ROUGHNESS_UM = 4.0, 30.0, 5.0, 0.4


@dataclass(frozen=True)
class FilmTable(
    Table,
    table="film",
    intro="The oil film of the big end's bearing; switches it on. What is left out is assumed, and the run "
    "says what",
    optional=True,
):
    """[film]: pressures are above that of the surroundings."""

    viscosity_mPas: float | None = key(
        "8.0",
        "dynamic, without pressure, at the temperature of the film",
        require_positive,
        Plausible(1.0, 200.0, "engine oils have 2 (hot) to 100 mPa·s (cold)"),
    )
    piezoviscosity_1_GPa: float | None = key(
        "13.0", "of the viscosity under pressure (Roelands); 0: none", within(0, 40)
    )
    radial_clearance_um: float | None = key(
        "25.0",
        "radius of the bore less that of the crank pin; default: half of contact.big_end_clearance_mm",
        require_positive,
        Plausible(0.3, 2.0, "about a thousandth of the radius is usual", {"rod.big_end_bore_mm": 1}, 4.0),
    )
    inlet_bar: float | None = key("4.0", "of the oil in the crank pin's hole", within(0.01, 100))
    hole_deg: float | None = key(
        "30.0",
        "angle of the hole in the crank pin, from the crank arm's outward direction in the sense of rotation",
        within(-360, 360),
    )
    hole_diameter_mm: float | None = key(
        "5.0", "", require_positive, Plausible(0.02, 0.4, "a tenth is usual", {"rod.big_end_bore_mm": 1}, 2.0)
    )
    roughness_um: float | None = key(
        "0.4", "of both surfaces together: the root of the sum of the squares of their Rq", not_negative
    )
