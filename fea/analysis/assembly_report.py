"""From the cases of an assembled rod to its figures."""

from collections.abc import Mapping
from dataclasses import fields

import numpy as np

from fea.analysis.assembly_figures import (
    AssemblyFigures,
    FaceCaseFigures,
    FitFigures,
    JointCaseFigures,
    JointCycleFigures,
    JointFigures,
    OvalityFigures,
)
from fea.analysis.assembly_onsets import Onsets
from fea.analysis.bolt_report import bolts_figures
from fea.analysis.figure_types import shape_figures, vector
from fea.analysis.prepare import PreparedRod
from fea.assess.bore_shape import bore_shape
from fea.assess.case_result import CaseResult
from fea.cycle.superposition import CycleResult
from fea.rod.assembly_state import AssemblyState, FaceState
from fea.study.expansion import REFERENCE_TEMPERATURE
from fea.units import DEG, UM
from geometry.surfaces import Surface
from loads.cases import ASSEMBLY

# The names of fits, by the seat.
FITS = {Surface.BUSHING_SEAT: "bushing", Surface.SHELL_SEAT: "shells"}


def assembly_figures(
    rod: PreparedRod, cases: Mapping[str, CaseResult], cycle: CycleResult | None = None
) -> AssemblyFigures | None:
    """Return the figures of bolts, joint and fits; None for a rod of one piece.

    Parameters
    ----------
    rod
        The rod.
    cases
        By name; `ASSEMBLY` is one of them.
    cycle
        The whole crank cycle, if it was worked out.
    """
    if rod.assembling is None or rod.putting is None:
        return None
    table = rod.assembling.table
    states = {name: case.assembly for name, case in cases.items() if case.assembly is not None}
    onsets = Onsets(rod, {name: case.load for name, case in cases.items()}, states)
    return AssemblyFigures(
        parts=tuple(rod.mesh.parts),
        temperature_C=REFERENCE_TEMPERATURE if table.temperature_C is None else table.temperature_C,
        bolts=bolts_figures(rod.assembling, states, cycle),
        joint=_joint(rod.putting.friction, states, onsets, cycle),
        fits={
            name: FitFigures(
                interference_mm=2 * rod.putting.interference.get(seat, 0.0),
                lifts_off=onsets.lifts_off(seat),
                by_case={case: _face(state.faces[seat]) for case, state in states.items()},
            )
            for seat, name in FITS.items()
            if seat in states[ASSEMBLY].faces
        },
        ovality={
            surface.value: {name: _ovality(case, surface, x) for name, case in cases.items()}
            for surface, x in (
                (Surface.SMALL_END_BORE, rod.mesh.bores.rod_length),
                (Surface.BIG_END_BORE, 0.0),
            )
        },
    )


def _joint(
    friction: float, states: Mapping[str, AssemblyState], onsets: Onsets, cycle: CycleResult | None
) -> JointFigures:
    assembled = states[ASSEMBLY]
    by_case = {}
    for name, state in states.items():
        joint, shared = state.joint, _face(state.joint)
        by_case[name] = JointCaseFigures(
            **{field.name: getattr(shared, field.name) for field in fields(shared)},
            clamp_force_N=joint.force,
            separating_N=state.separating(assembled),
            edge_pressure_MPa=joint.edge_pressure,
            shear_N=joint.shear,
            slip_reserve=joint.slip_reserve,
        )
    return JointFigures(
        friction=friction,
        opens=onsets.opens(),
        separates=onsets.separates(),
        by_case=by_case,
        cycle=None if cycle is None else _joint_cycle(cycle),
    )


def _joint_cycle(cycle: CycleResult) -> JointCycleFigures:
    joint, angle = [state.joint for state in cycle.states], cycle.angles / DEG
    clamp, opening = np.array([own.force for own in joint]), np.array([own.opening for own in joint])
    least, widest = int(clamp.argmin()), int(opening.argmax())
    reserves = [own.slip_reserve for own in joint if own.slip_reserve is not None]
    return JointCycleFigures(
        min_clamp_force_N=float(clamp[least]),
        min_clamp_crank_deg=float(angle[least]),
        max_opening_um=float(opening[widest]) / UM,
        max_opening_crank_deg=float(angle[widest]),
        open_percent=100 * float(np.mean([own.edge_pressure == 0 for own in joint])),
        min_slip_reserve=min(reserves, default=None),
    )


def _face(face: FaceState) -> FaceCaseFigures:
    return FaceCaseFigures(
        mean_pressure_MPa=face.mean,
        min_pressure_MPa=face.least,
        max_pressure_MPa=face.largest,
        open_percent=100 * face.open_share,
        opening_um=face.opening / UM,
        opening_at_mm=None if face.opening_at is None else vector(face.opening_at),
        slipping_percent=100 * face.slipping_share,
        slip_um=face.slip / UM,
    )


def _ovality(case: CaseResult, surface: Surface, x: float) -> OvalityFigures:
    return OvalityFigures(**shape_figures(bore_shape(case.mesh, surface, x, case.distortion)))
