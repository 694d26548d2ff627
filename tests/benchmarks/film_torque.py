"""The friction of a bearing on a rig, from full to mixed films, against its measurement.

    python tests/benchmarks/film_torque.py

Sander, Allmaier, Priebsch, Witt & Skiadas, Simulation of journal bearing friction in severe mixed
lubrication: a big end of 47.8 by 17.2 mm between two support bearings of 54 by 25 mm, loaded with 10 MPa.
Dimensions, oil, surfaces (roughness of the summits, their mean height, K = 1e-3, E* = 53.3 GPa) and the
measured torque are from the tests of the public package mboct-mbdyn-pkg, which repeats the rig and assumes
clearances and the shape of the rod. Here the rod is a ring of the rod's width, the supports are thick rings,
and the oil is supplied through an axial groove opposite to the load.
"""

import math
from dataclasses import dataclass

import numpy as np

from fea.film.asperities import Asperities
from fea.film.functions import BoreFunctions
from fea.film.grid import FilmGrid
from fea.film.journal import Bearing, ElasticBore
from fea.film.oil import Oil
from fea.film.reynolds import Conditions, Reynolds, Supply
from fea.pins.lubrication import FINE

# Torque, N·m, by speed, rpm.
MEASURED = {
    3000: 1.06,
    1000: 0.544,
    500: 0.43,
    400: 0.46,
    300: 0.58,
    250: 0.747,
    200: 1.076,
    150: 1.71,
}  # N·m
ROUGHNESS, SUMMITS, FRICTION = math.hypot(0.13e-3, 0.28e-3), 0.60e-3, 0.02  # mm, mm, 1
CLEARANCE = 1e-3  # over the radius, assumed there
OIL = Oil(6.8e-9, 13e-3)


@dataclass(frozen=True)
class RaisedAsperities(Asperities):
    """Summits that lie above the mean planes by a height."""

    def pressure(self, gap):
        """Pressure at gaps between the mean planes."""
        return super().pressure(gap - SUMMITS)


def ring(inner: float, outer: float, n: int, modulus: float, nu: float = 0.3) -> float:
    """Displacement of a ring's inside under a pressure cos nφ of 1 MPa, mm; plane stress (Michell 1899)."""
    if n == 1:
        return 0.0  # it moves as a whole
    if n == 0:
        square = inner**2, outer**2
        return inner / modulus * (sum(square) / (square[1] - square[0]) + nu)
    r = np.array([inner, outer])
    powers = np.stack([r ** (n - 2.0), r ** float(n), r ** (-n - 2.0), r ** float(-n)])
    radial = np.array([-n * (n - 1), -(n + 1) * (n - 2), -n * (n + 1), -(n + 2) * (n - 1)])
    shear = np.array([n * (n - 1), n * (n + 1), -n * (n + 1), -n * (n - 1)])
    rows = np.concatenate([radial[:, None] * powers, shear[:, None] * powers], axis=1).T
    factors, kappa = np.linalg.solve(rows, [-1.0, 0.0, 0.0, 0.0]), (3 - nu) / (1 + nu)
    moves = np.array([-n, kappa - n - 1, n, kappa + n - 1]) * inner ** np.array(
        [n - 1.0, n + 1, -n - 1, 1 - n]
    )
    return float(moves @ factors) / (modulus / (1 + nu))


def torques(diameter: float, width: float, force: float, outer: float, modulus: float) -> dict[int, float]:
    """Torque, N·m, by speed, rpm: from the fastest to the slowest, each from the film before."""
    radius = diameter / 2
    grid, functions = FilmGrid(radius, width, *FINE[:2], graded=1.0), BoreFunctions(radius, width)
    yields = [ring(radius, outer, n, modulus) for n in range(functions.terms[:, 0].max() + 1)]
    harmonics = functions.terms[:, 0]
    compliance = np.diag([yields[n] for n in (*harmonics, *harmonics[harmonics > 0])])
    rough = RaisedAsperities(ROUGHNESS, 1e-3 * 53.3e3, FRICTION)
    ends = np.concatenate(functions.at(grid.angle, np.full(grid.n_angle, width / 2)))
    bore = ElasticBore(functions.means(grid), ends.T[:, None], compliance)
    bearing = Bearing(Reynolds(grid, OIL), CLEARANCE * radius, bore, rough)
    supply = Supply(grid.groove(math.pi, 0.25), 0.1)
    state, found = bearing.start(), {}
    for rpm, share in ((3000, 0.1), (3000, 0.5), *((rpm, 1.0) for rpm in MEASURED)):
        speed = rpm * math.pi / 30 * radius
        state = bearing.solve(state, Conditions(speed, supply), load=np.array([share * force, 0.0]))
        found[rpm] = bearing.friction(state, speed)[0] * radius / 1e3
    return found


def main() -> None:
    """Print measured and computed torque."""
    force = 10.0 * 47.8 * 17.2
    rod = torques(47.8, 17.2, force, outer=50.0, modulus=70e3)
    support = torques(54.0, 25.0, force / 2, outer=60.0, modulus=210e3)
    print("rpm, measured, computed, N·m")
    for rpm, measured in MEASURED.items():
        print(f"{rpm:5d} {measured:6.3f} {rod[rpm] + 2 * support[rpm]:6.3f}")


if __name__ == "__main__":
    main()
