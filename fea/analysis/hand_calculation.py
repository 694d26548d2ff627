"""The hand calculation of a connecting rod, beside what the finite elements give.

The formulas are those of textbooks: inertia of the reciprocating mass, the split of the rod's mass between
its ends, the modified Goodman line (Budynas & Nisbett, Shigley's Mechanical Engineering Design, 9th ed.,
section 6-12), Johnson's column (there, chapter 4) and the bolt of a clamped joint (VDI 2230-1:2015).
"""

from collections.abc import Iterator, Mapping
from math import isclose, pi

import numpy as np

from fea.analysis.buckling import compression, part_at
from fea.analysis.prepared_rod import PreparedRod
from fea.analysis.summary_figures import (
    AssemblyFigures,
    BucklingFigures,
    HandFigures,
    PlaneFigures,
    Summary,
)
from fea.base.choices import Fatigue, Region
from fea.base.units import BAR, GPA, KG, KN, RPM
from fea.judge.case_result import CaseResult
from fea.judge.column import ColumnLoads, Plane
from fea.judge.fatigue import goodman
from fea.rod.loading import EngineLoading
from geometry.section import CrossSection
from mesh.slices import cut


def inertia_force(mass: float, radius: float, speed: float, ratio: float, rotating: float = 0.0) -> float:
    """Inertia at top dead centre, N: m r ω² (1 + λ), and of a mass that turns with the crank pin m r ω².

    Masses in t, crank radius in mm, speed in rad/s; `ratio`: λ of crank radius to rod length.
    """
    return radius * speed**2 * (mass * (1 + ratio) + rotating)


def gas_force(pressure: float, bore: float) -> float:
    """Return the gas force p π D²/4, N, of a gauge pressure, MPa, on a piston in a bore, mm."""
    return pressure * pi * bore**2 / 4


def bolt_force(preload: float, load_factor: float, load: float, bolts: int) -> float:
    """Return the force of each of some bolts, N: F_V + Φ F/n of a joint that a load, N, pulls apart."""
    return preload + load_factor * load / bolts


def johnson_load(
    section: CrossSection, plane: Plane, length: float, youngs_modulus: float, strength: float
) -> float:
    """Critical load, N, of a uniform column by Johnson's parabola, or by Euler's formula where it is slender.

    Length in mm, modulus and yield strength in MPa. Sideways both ends are built in.
    """
    effective = plane.length_factor * length
    euler = pi**2 * youngs_modulus * plane.inertia(section) / effective**2
    return ColumnLoads(effective / plane.gyration(section), euler, strength * section.area).johnson


def hand_calculation(
    rod: PreparedRod, cases: Mapping[str, CaseResult], summary: Summary
) -> dict[str, HandFigures]:
    """Work out by hand what can be, with the ratio of the finite elements' result to it, by name."""
    found: dict[str, HandFigures] = {}
    rpm, assembly = summary.rpm, summary.assembly
    if isinstance(rod.loading, EngineLoading) and rpm is not None:
        found |= _forces(rod, rod.loading, cases, rpm * RPM)
    stresses = dict(_shank_stresses(rod, cases))
    found |= stresses
    if {"shank_pulled", "shank_pushed"} <= stresses.keys():
        found |= _goodman(rod, stresses, summary)
    if assembly is not None and "tension" in cases:
        found |= _bolts(assembly, float(cases["tension"].load.crank_axial))
    return found | dict(_column(rod, summary.buckling))


def _compared(  # noqa: PLR0917 - the columns of its table
    title: str, formula: str, inputs: str, value: float, unit: str, result: float, result_of: str, why: str
) -> HandFigures:
    ratio = result / value if value else None
    return HandFigures(
        title=title, formula=formula, inputs=inputs, value=value, unit=unit, result=result,
        result_of=result_of, ratio=ratio, why=why,
    )  # fmt: skip


def _forces(
    rod: PreparedRod, loading: EngineLoading, cases: Mapping[str, CaseResult], speed: float
) -> Iterator[tuple[str, HandFigures]]:
    engine, length = loading.engine, rod.mesh.bores.rod_length
    radius, ratio = engine.crank_radius, engine.crank_radius / engine.rod_length
    crank = f"r = {radius:.4g} mm, ω = {speed:.4g} rad/s, λ = r/l = {ratio:.3f}"
    if "tension" in cases and speed > 0:
        load, piston = cases["tension"].load, engine.piston_mass
        moving = rod.mass.mass * rod.mass.center[0] / length
        turning = rod.mass.mass - moving
        acts = "presses against it" if load.gas > 0 else "pulls with it"
        gas = (
            f"The gas {acts}, with {abs(float(load.gas)) / KN:.2f} kN at that crank angle."
            if load.gas
            else ""
        )
        yield "piston_inertia", _compared(
            "Inertia of the piston", "F = m r ω² (1 + λ)", f"m = {piston / KG:.4g} kg, {crank}",
            inertia_force(piston, radius, speed, ratio) / KN, "kN", float(load.pin_axial) / KN,
            "pull at the piston pin in the case tension",
            gas or "Without gas the formula is exact at the dead centre.",
        )  # fmt: skip
        yield "inertia", _compared(
            "Inertia at the crank pin", "F = (m + m₁) r ω² (1 + λ) + m₂ r ω²",
            f"m₁ = {moving / KG:.4g} kg of the rod moves with the piston, m₂ = {turning / KG:.4g} kg turns "
            "with the crank pin; the rest as above",
            inertia_force(piston + moving, radius, speed, ratio, turning) / KN, "kN",
            float(load.crank_axial) / KN, "pull at the crank pin in the case tension",
            gas or "At the dead centre two point masses give the force of the rod exactly.",
        )  # fmt: skip
    if "gas" in cases:
        angles = np.union1d(engine.cycle_angles, loading.gas.samples)
        pressure = float(np.max(loading.gas.pressure(angles, np.asarray(speed))))
        yield "gas", _compared(
            "Gas force", "F = p π D²/4", f"p = {pressure / BAR:.1f} bar (gauge), D = {engine.bore:.4g} mm",
            gas_force(pressure, engine.bore) / KN, "kN", -float(cases["gas"].load.pin_axial) / KN,
            "push in the case gas", "Both are the same formula; the ratio shows that the peak was met.",
        )  # fmt: skip


def _shank_stresses(rod: PreparedRod, cases: Mapping[str, CaseResult]) -> Iterator[tuple[str, HandFigures]]:
    """Yield F/A at the least section against the mean axial stress over it, and the peak of the case."""
    section = rod.shank[1]
    sliced = cut(rod.mesh.whole, section.x)
    pulls = {name: float(max(case.load.pin_axial, case.load.crank_axial)) for name, case in cases.items()}
    # The gas alone is no instant of the cycle, whose amplitude Goodman's line needs.
    pushes = {name: float(compression(case.load)) for name, case in cases.items() if name != "gas"}
    for name, words, sign, forces in (
        ("shank_pulled", "pulled", 1.0, pulls),
        ("shank_pushed", "pushed", -1.0, pushes),
    ):
        case = max(forces, key=lambda name: forces[name], default="")
        if not case or forces[case] <= 0:
            continue
        stress = sliced.at_corners(cases[case].stress[:, :1]).mean(axis=1)[:, 0]
        mean = float(sliced.areas @ stress / sliced.areas.sum())
        peak = cases[case].max_von_mises
        yield name, _compared(
            f"Mean stress of the shank, {words}", "σ = F/A",
            f"F = {forces[case] / KN:.2f} kN ({case}), A = {section.area:.4g} mm² at x = {section.x:.1f} mm",
            sign * forces[case] / section.area, "MPa", mean, "mean axial stress over that section",
            "F is the larger force at either pin, of which the inertia of the rod beyond the section takes "
            f"part; the peak of the case, {peak:.0f} MPa, is {peak * section.area / forces[case]:.1f} times "
            "F/A by notches, contact and bending.",
        )  # fmt: skip


def _goodman(
    rod: PreparedRod, stresses: Mapping[str, HandFigures], summary: Summary
) -> Iterator[tuple[str, HandFigures]]:
    envelope, survival = summary.envelope, summary.survival
    material = rod.materials[part_at(rod.mesh.whole, rod.shank[1].x)]
    limit, ultimate = material.endurance_limit, material.ultimate_strength
    found = survival.fatigue_at_most if envelope is None else envelope.min_fatigue_safety_factor
    if limit is None or ultimate is None or found is None:
        return
    highest, lowest = stresses["shank_pulled"].value, stresses["shank_pushed"].value
    mean, amplitude = (highest + lowest) / 2, (highest - lowest) / 2
    endurance = limit * material.marin.surfaces[Region.REST].factor
    spot = None if envelope is None else envelope.fatigue
    where = survival.fatigue_where if spot is None else spot.where
    line = "" if rod.options.fatigue is Fatigue.GOODMAN else f" (by the line of {rod.options.fatigue.value})"
    yield "goodman", _compared(
        "Fatigue of the shank", "1/n = σ_a/S_e + σ_m/S_u (Goodman)",
        f"σ_m = {mean:.1f} MPa, σ_a = {amplitude:.1f} MPa, S_e = {endurance:.4g} MPa, "
        f"S_u = {ultimate:.4g} MPa",
        float(goodman(np.array(mean), np.array(amplitude), endurance, ultimate)), "", float(found),
        f"least factor of the whole rod{line}",
        f"The least factor is where stress concentrates ({where or 'at a notch'}), not in the plain section.",
    )  # fmt: skip


def _bolts(assembly: AssemblyFigures, load: float) -> Iterator[tuple[str, HandFigures]]:
    bolts = assembly.bolts
    places = [bolt.at_mm for bolt in next(iter(bolts.by_case.values()))]
    # A bolt away from z = 0 without one opposite stands for a pair.
    count = sum(
        1 if any(isclose(x, -z, abs_tol=1e-6) for _, _, x in places) else 2 for _, _, z in places
    )  # fmt: skip
    yield "bolt", _compared(
        "Force of a bolt", "F_S = F_V + Φ F/n",
        f"F_V = {bolts.preload_N / KN:.2f} kN, Φ = {bolts.vdi_load_factor:.3f}, F = {load / KN:.2f} kN, "
        f"n = {count}",
        bolt_force(bolts.preload_N, bolts.vdi_load_factor, load, count) / KN, "kN", bolts.max_force_N / KN,
        "largest force of any bolt",
        "The load does not act on the axis of the bolts: the cap bends, which the load factor of a central "
        "load does not contain.",
    )  # fmt: skip


def _column(rod: PreparedRod, buckling: BucklingFigures) -> Iterator[tuple[str, HandFigures]]:
    planes: Mapping[str, PlaneFigures] = buckling.column.planes
    section, length = rod.shank[1], rod.mesh.bores.rod_length
    material = rod.materials[part_at(rod.mesh.whole, section.x)]
    modulus, strength = material.youngs_modulus, material.yield_strength
    loads = {plane: johnson_load(section, plane, length, modulus, strength) for plane in Plane}
    plane = min(loads, key=lambda plane: loads[plane])
    inertia, way = plane.inertia(section), "in the plane of motion" if plane is Plane.IN_PLANE else "sideways"
    yield "column", _compared(
        f"Johnson's column, {way}", "F = S_y A (1 − S_y A/4F_E), F_E = π² E I/(K l)²",
        f"A = {section.area:.4g} mm², I = {inertia:.4g} mm⁴, l = {length:.4g} mm, "
        f"K = {plane.length_factor:g}, E = {modulus / GPA:.4g} GPa, S_y = {strength:.4g} MPa",
        loads[plane] / KN, "kN", planes[plane.value].johnson_N / KN,
        "the same with the section that varies from pin to pin",
        "By hand the least section reaches from pin to pin; the real ends are far stiffer.",
    )  # fmt: skip
