"""Free–free beam: bending frequencies with shear and rotary inertia.

(f_EB/f)² = 1 + (r/L)² (F² + 6F + (E/κG)(F² − 2F)) to first order in (r/L)², with the Euler–Bernoulli
frequency f_EB = (βL)²/2πL² r √(E/ρ), F = βL (cosh βL − cos βL)/(sinh βL − sin βL) and κ = 10(1 + ν)/(12 +
11ν) (Cowper 1966). Without shear and rotary inertia the third mode in the thick plane would be 1.8 % off.
"""

import math

from fea.base.material import Material
from fea.solvers.vibration import RIGID, free_modes
from fea.verify.benchmark import Benchmark, Computed, Goal
from geometry.bodies import block
from mesh.generate import mesh_body

STEEL = Material(youngs_modulus=207e3, poissons_ratio=0.3, density=7.8e-9, yield_strength=400.0)
LENGTH, THIN, THICK = 1000.0, 20.0, 30.0
ROOTS = (4.730041, 7.853205, 10.995608)  # of cos βL cosh βL = 1


def bending(height: float, root: float) -> float:
    """Frequency, Hz, of the mode with the root βL in the plane in which the beam is `height` thick, mm."""
    nu, radius = STEEL.poissons_ratio, height / math.sqrt(12)
    plain = root**2 / (2 * math.pi * LENGTH**2) * math.sqrt(STEEL.youngs_modulus / STEEL.density) * radius
    stretch = root * (math.cosh(root) - math.cos(root)) / (math.sinh(root) - math.sin(root))
    kappa = 10 * (1 + nu) / (12 + 11 * nu)
    rotary = stretch**2 + 6 * stretch
    shear = 2 * (1 + nu) / kappa * (stretch**2 - 2 * stretch)
    return plain / math.sqrt(1 + (radius / LENGTH) ** 2 * (rotary + shear))


GOALS = tuple(
    sorted(
        (
            Goal(
                f"bending mode {number}, {height:g} mm thick",
                "Hz",
                bending(height, root),
                0.2,
                "the error of the theory is 1e-4 for such slender modes; elements longer than the beam is "
                "thick add up to 1.3e-3",
            )
            for height in (THIN, THICK)
            for number, root in enumerate(ROOTS, start=1)
        ),
        key=lambda goal: goal.target,
    )
)


def compute(size: float) -> Computed:
    """Find the first elastic modes with elements of `size`."""
    mesh = mesh_body(block(LENGTH, THIN, THICK), size)
    elastic = free_modes(mesh, STEEL, STEEL.density, len(GOALS)).frequencies[RIGID:]
    found = {goal.quantity: float(hertz) for goal, hertz in zip(GOALS, elastic, strict=True)}
    return Computed(found, mesh.points.size)


BENCHMARK = Benchmark(
    title="Free–free beam: bending frequencies",
    source="Goens 1931, Annalen der Physik 403, 649-678 (Timoshenko beam, first order)",
    goals=GOALS,
    compute=compute,
    size=25.0,
    converges=False,
)
