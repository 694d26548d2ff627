"""Liquid in the cylinder when the valves shut: by how much the rod must give way at a force on the piston."""

import math
from dataclasses import dataclass

# Bulk modulus of water at 20 °C, MPa; petrol and coolant yield more, by a third and less.
BULK = 2200.0


@dataclass(frozen=True)
class TrappedLiquid:
    """Liquid and gas, compressed without combustion; volumes in mm³, absolute pressures in MPa."""

    liquid: float  #: when the intake shuts
    closed: float  #: of the cylinder with the piston at the bottom, or when the port of a two-stroke shuts
    chamber: float  #: of the cylinder at top dead centre
    piston_area: float  #: mm²
    intake: float  #: pressure of the gas when the intake shuts
    crankcase: float
    exponent: float  #: n of p Vⁿ = const

    def pressure(self, force: float) -> float:
        """Absolute pressure, MPa, with a force, N, on the piston."""
        return self.crankcase + force / self.piston_area

    def work(self, force: float) -> float:
        """Work, N·mm, that compresses gas and liquid until a force, N, acts on the piston, from its own."""
        pressure, gas, n = self.pressure(force), self.closed - self.liquid, self.exponent
        ratio = pressure / self.intake
        compressed = math.log(ratio) if n == 1 else (ratio ** (1 - 1 / n) - 1) / (n - 1)
        below = self.crankcase * gas * (1 - ratio ** (-1 / n))
        of_liquid = self.liquid * (pressure - self.intake) ** 2 / (2 * BULK)
        return float(self.intake * gas * compressed - below + of_liquid)

    def shortening(self, force: float) -> float:
        """How far below top dead centre, mm, the piston stops if a force, N, stops it; negative: above."""
        pressure = self.pressure(force)
        gas = (self.closed - self.liquid) * (self.intake / pressure) ** (1 / self.exponent)
        liquid = self.liquid * (1 - (pressure - self.intake) / BULK)
        return float((gas + liquid - self.chamber) / self.piston_area)
