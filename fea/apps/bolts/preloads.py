"""What the joint of one rod does under other preloads, from a few of them whose contact is solved.

Parts, mesh and compliance stay as they are; only the force to which the bolts are tightened changes, so that
a state costs a step of contact and no further factorisation. Between the solved preloads, what bolts gain in
force and bending is interpolated by monotone cubics (Fritsch & Carlson 1980). A stiffer or softer bolt of
another thread meets the parts where the present one does under another preload, in the joint diagram of VDI
2230-1; its bending is that of its own beam between the same seats.
"""

from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from fea.analysis.prepared_rod import PreparedRod
from fea.apps.limits.engine import ScaledEngine
from fea.contact.assembly_state import AssemblyState
from fea.contact.friction_system import ContactState
from fea.judge.bolt import BoltResult, TightenedBolt
from fea.pins.assembly import AssemblyContact, AssemblyPins
from fea.solid.errors import ContactError
from fea.study.assembly_table import Thread
from geometry.arrays import Floats
from loads.instants import ASSEMBLY, Instants, joined

# Preloads that are solved beside the present one.
_SOLVED = 5
# Steps to the preload under which the present bolt is like another one; each is a fifth of the one before.
_MOST = 20
# Of the present preload: at least that range is solved.
_LESS = 0.9
# Relative difference of equal forces.
_ALIKE = 1e-6
# To which the speed at which the joint opens is found, over itself, and the first steps towards it.
_WITHIN, _STEP = 0.01, 1.15
# Stands for the pressure at an edge that has opened, over that without load: its sign is what matters.
_OPEN = -0.1


class _Solved(NamedTuple):
    """The parts under a preload, N: the state in each load case, and the opening speed, rpm."""

    preload: float
    contact: AssemblyContact
    states: list[ContactState]
    opens: float


class PreloadedJoint:
    """The joint of a rod over the preload of its bolts, at a speed, rpm.

    `present`: the bolts that the contact is solved with; `preloads`, N: those that are asked for, between
    whose least and largest some are solved. Where no contact carries a small one, nothing is known of it.
    """

    def __init__(
        self,
        rod: PreparedRod,
        pins: AssemblyPins,
        rpm: float,
        present: TightenedBolt,
        preloads: Sequence[float],
    ) -> None:
        self._rod, self.present, self._rpm = rod, present, rpm
        engine = ScaledEngine(rod.engine, rod.mass)
        #: least, most: speeds, rpm, between which opening is looked for
        self.least, self.most = engine.idle, engine.fastest
        self._cases = joined([rod.loading.at(rod.mass, rpm).cases, pins.resting])
        # Speeds, rpm, and the load on the joint there, N, in the case that pulls at it most.
        self._pulled = list[tuple[float, float]]()
        around = np.geomspace(min(*preloads, _LESS * present.preload), max(preloads), _SOLVED)
        every = np.sort([*around[np.abs(around / present.preload - 1) > 0.02], present.preload])
        solved, like = list[_Solved](), dict[str, ContactState]()
        for preload in every[::-1].tolist():  # a joint that holds settles soonest
            with suppress(ContactError):
                contact = pins.assembly.tightened_to(preload)
                states = [_step(contact, case, like) for case in self._cases]
                guess = solved[-1].opens * np.sqrt(preload / solved[-1].preload) if solved else rpm
                opens = self._opening(contact, states, float(guess), like)
                solved.append(_Solved(preload, contact, states, opens))
        self._solved = solved[::-1]
        self._bolts = len(pins.assembly.assembled.bolts)
        self.forces = np.array([one.preload for one in self._solved])  #: preloads that are solved, N
        self._courses = dict[tuple[Thread, float], PchipInterpolator]()

    def _opening(
        self,
        contact: AssemblyContact,
        states: list[ContactState],
        guess: float,
        like: dict[str, ContactState],
    ) -> float:
        """Speed, rpm, at which the joint opens at the bore: 0 where it does at any, `most` where at none."""
        summed = [contact.sums(state) for state in states]
        rest = next(state for case, state in zip(self._cases, summed, strict=True) if case.name == ASSEMBLY)
        pulled = [-np.inf if state is rest else state.separating(rest) for state in summed]
        worst = int(np.argmax(pulled))
        self._pulled.append((self._rpm, pulled[worst]))
        name, at_rest = self._cases[worst].name, rest.joint.edge_pressure or 0.0
        if at_rest <= 0:
            return 0.0
        known = {self._rpm: summed[worst].joint.edge_pressure or _OPEN * at_rest}

        def left(speed: float) -> float:
            if speed not in known:
                cases = self._rod.loading.at(self._rod.mass, speed).cases
                case = next((each for each in cases if each.name == name), None)
                if case is None:  # at low speed nothing may pull
                    return at_rest
                try:
                    state = contact.sums(_step(contact, case, like, f"{name} at another speed"))
                except ContactError:
                    return _OPEN * at_rest
                self._pulled.append((speed, state.separating(rest)))
                known[speed] = state.joint.edge_pressure or _OPEN * at_rest
            return known[speed]

        low = high = min(max(guess, self.least), self.most)
        while left(high) > 0:
            if high >= self.most:
                return self.most
            low, high = high, min(_STEP * high, self.most)
        while left(low) <= 0:
            if low <= self.least:
                return 0.0
            low, high = max(low / _STEP, self.least), low
        return float(brentq(left, low, high, xtol=_WITHIN * low, disp=False))

    def covers(self, bolt: TightenedBolt) -> bool:
        """Whether a preload is among those that are solved."""
        at = bolt.preload
        return self.forces.size > 1 and self.forces[0] * (1 - _ALIKE) <= at <= self.forces[-1] * (1 + _ALIKE)

    def solved(self, bolt: TightenedBolt) -> bool:
        """Whether a bolt is the present one, or one like it under a preload that is solved."""
        alike = bolt.bolt.thread == self.present.bolt.thread
        return alike and bool((np.abs(self.forces / bolt.preload - 1) < _ALIKE).any())

    def judged(self, bolt: TightenedBolt) -> list[BoltResult] | None:
        """Judge each bolt over the load cases and at rest; None outside of the preloads that are solved."""
        if not self.covers(bolt):
            return None
        gained, bending, shear = np.split(self._gains(bolt), [1, 4], axis=-1)
        forces = bolt.preload + gained[..., 0]
        fibre = forces / bolt.bolt.least_area + bending[..., 2]
        shear = shear * (bolt.bolt.play <= self.present.bolt.play)  # with more play friction carries it
        return [
            BoltResult.of(bolt, forces[:, k], fibre[:, k], bending[:, k, :2], float(shear[:, k].max()))
            for k in range(forces.shape[1])
        ]

    def opens_at(self, bolt: TightenedBolt) -> float | None:
        """Speed, rpm, at which the joint opens: 0 where at any, `most` where at none; None: unknown."""
        if not self.covers(bolt):
            return None
        squared = np.square([one.opens for one in self._solved])  # inertia, like the preload that it undoes
        return float(np.sqrt(np.interp(bolt.preload, self.forces, squared)))

    def load_factor(self, rpm: float) -> float:
        """Load on the joint at a speed, rpm, over that at the study's, in the case that pulls at it most.

        Inertia makes it linear in the square of the speed, but for a percent by the seats of the shells. It
        is infinite where nothing pulls at the speed of the study.
        """
        if rpm == 0:
            return 0.0
        speeds, pulled = np.array(self._pulled).T
        line = np.polynomial.Polynomial.fit(speeds**2, pulled, 1, w=1 / speeds**2)
        own = float(line(self._rpm**2))
        return float(line(rpm**2)) / own if own > 0 else np.inf

    def _gains(self, bolt: TightenedBolt) -> Floats:
        """What a bolt gains in each state: (cases, bolts, 5) as of `_course`.

        In the diagram of VDI 2230 a bolt of compliance δ_S' under the preload F_V' meets the parts where the
        present one does under F_V = F_V' − ΔF (δ_S' − δ_S)/(δ_S' + δ_P), whose gain ΔF depends on F_V where
        the joint opens; while it is closed, ΔF is in proportion to the load factor δ_P/(δ_S + δ_P).
        """
        course, own = self._course(bolt), bolt.bolt.compliance
        share = (own - self.present.bolt.compliance) / (own + bolt.parts_compliance)
        cases, bolts = (index.ravel() for index in np.indices((len(self._cases), self._bolts)))
        found, preload = np.zeros((cases.size, 5)), np.full(cases.size, bolt.preload)
        for _ in range(_MOST):
            found = course(preload)[np.arange(cases.size), cases, bolts]
            preload = bolt.preload - found[:, 0] * share
        found[:, 0] += preload - bolt.preload
        return np.asarray(found.reshape(len(self._cases), self._bolts, -1))

    def _course(self, bolt: TightenedBolt) -> PchipInterpolator:
        """By the preload: (cases, bolts, 5) gain of force, N, bending of thread and fibre, MPa, shear, N."""
        key = bolt.bolt.thread, bolt.bolt.compliance
        if key not in self._courses:
            values = [
                [_figures(state, one.preload, bolt) for state in self._states(one, bolt)]
                for one in self._solved
            ]
            self._courses[key] = PchipInterpolator(self.forces, np.array(values), axis=0)
        return self._courses[key]

    def _states(self, solved: _Solved, bolt: TightenedBolt) -> list[AssemblyState]:
        sums = solved.contact.sums.of(solved.contact.assembled, bolt.bolt.beam)
        return [sums(state) for state in solved.states]


def _step(
    contact: AssemblyContact, case: Instants, like: dict[str, ContactState], name: str | None = None
) -> ContactState:
    """Solve a load case from rest; `like` holds a state of the same case under another preload or speed."""
    (load,) = contact.loads(case[None])
    name = name or case.name
    like[name] = contact.assembled.steps().step(load, contact.assembled.start, like.get(name))
    return like[name]


def _figures(state: AssemblyState, preload: float, bolt: TightenedBolt) -> Floats:
    area = bolt.bolt.least_area
    return np.array(
        [
            (one.force - preload, *one.thread_bending, one.fibre - one.force / area, one.shear)
            for one in state.bolts
        ]
    )
