"""How the bores of a rod in parts yield while the parts hold together as in one of their states.

What is closed in that state sticks, what is open moves freely: the parts answer in proportion to the load.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fea.contact.assembled import Assembled
from fea.contact.friction_system import ContactState
from fea.solid.parity import Parity
from geometry.arrays import Floats
from geometry.errors import require


@dataclass(frozen=True)
class HeldParts:
    """Parts that are put together, and loads on them; made by `under`."""

    assembled: Assembled
    gap: Floats  #: (n, k) moments of the gaps that k loads open where each part is held by itself
    resultant: Floats  #: (m, k) of these loads along the free motions of the parts
    grown: Floats  #: (k,) their work on the free thermal expansion

    @classmethod
    def under(
        cls, assembled: Assembled, forces: Mapping[Parity, Floats], u: Mapping[Parity, Floats]
    ) -> "HeldParts":
        """Load parts.

        `forces`: (n_own, n_nodes, 3) of each parity on the cell, N, and `u` (n_nodes, 3, n_own), mm, what
        they do to the parts as each is held by itself. Raises `InvalidValue`: nothing but the pins holds a
        part.
        """
        problem, images = assembled.problem, assembled.problem.unfolding.images
        rule = "leaves a part that nothing but the pins holds, so that its bore cannot carry an oil film"
        held = not assembled.system.loose.size
        require(held, "assembly.joint_friction", 0.0, rule, "Give friction, or shells that centre the cap.")
        gaps, resultants = [], []
        for parity, own in forces.items():
            flat = own.reshape(len(own), -1)
            opened = problem.forces.T @ u[parity].reshape(flat.shape[1], -1)
            even = parity is Parity.SYMMETRIC
            gaps.append(problem.gaps(opened) if even else problem.gaps(0.0 * opened, opened))
            along = [(of is parity) * (flat @ motion) for of, motion in assembled.motions]
            resultants.append(images * np.reshape(along, (-1, len(own))))
        gap, grown = np.hstack(gaps), np.zeros(sum(map(len, forces.values())))
        if assembled.warming is not None:
            own = forces[Parity.SYMMETRIC]
            grown[: len(own)] = images * own.reshape(len(own), -1) @ assembled.warming.displacement
        return cls(assembled, gap, np.hstack(resultants), grown)

    def adding(self, state: ContactState | None = None) -> tuple[Floats, Floats]:
        """Work (k, k) that the hold of the parts adds to that of the loads, and made (k,).

        `state`: what is open in it moves freely, by default at the engine's temperature. The second is the
        work of the loads on what the parts move by themselves from where they were put together, when the
        bores were made, to the state.
        """
        parts, start, before = self.assembled, self.assembled.start, self.assembled.tightened
        unloaded = start.load.gap.copy()
        unloaded[parts.interface] -= start.gap
        values, motions = parts.sticking(
            np.column_stack([self.gap, unloaded]),
            np.pad(self.resultant, [(0, 0), (0, 1)]),
            parts.opened(state or start),
        )
        values[:, -1] -= before.values
        motions[:, -1] -= parts.system.part_motion(before)
        work = self.gap.T @ values + self.resultant.T @ motions
        return work[:, :-1], work[:, -1] + self.grown
