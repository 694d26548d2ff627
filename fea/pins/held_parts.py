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
    """Parts that are put together, and a state of them, by default that at the engine's temperature."""

    assembled: Assembled
    state: ContactState | None = None

    def adding(self, forces: Mapping[Parity, Floats], u: Mapping[Parity, Floats]) -> tuple[Floats, Floats]:
        """Work (k, k) that the hold of the parts adds to that of k loads on them, and made (k,).

        `forces`: (n_own, n_nodes, 3) of each parity on the cell, N, and `u` (n_nodes, 3, n_own), mm, what
        they do to the parts as each is held by itself. The second is the work of the loads on what the parts
        move by themselves from where they were put together, when the bores were made, to the state. Raises
        `InvalidValue`: nothing but the pins holds a part.
        """
        parts, problem = self.assembled, self.assembled.problem
        images = problem.unfolding.images
        rule = "leaves a part that nothing but the pins holds, so that its bore cannot carry an oil film"
        held = not parts.system.loose.size
        require(held, "assembly.joint_friction", 0.0, rule, "Give friction, or shells that centre the cap.")
        gaps, resultants = [], []
        for parity, own in forces.items():
            flat = own.reshape(len(own), -1)
            opened = problem.forces.T @ u[parity].reshape(flat.shape[1], -1)
            even = parity is Parity.SYMMETRIC
            gaps.append(problem.gaps(opened) if even else problem.gaps(0.0 * opened, opened))
            along = [(of is parity) * (flat @ motion) for of, motion in parts.motions]
            resultants.append(images * np.reshape(along, (-1, len(own))))
        gap, resultant = np.hstack(gaps), np.hstack(resultants)
        start, before = parts.start, parts.tightened
        unloaded = start.load.gap.copy()
        unloaded[parts.interface] -= start.gap
        values, motions = parts.sticking(
            np.column_stack([gap, unloaded]),
            np.pad(resultant, [(0, 0), (0, 1)]),
            parts.opened(self.state or start),
        )
        values[:, -1] -= before.values
        motions[:, -1] -= parts.system.part_motion(before)
        work = gap.T @ values + resultant.T @ motions
        made = work[:, -1]
        if parts.warming is not None:
            own = forces[Parity.SYMMETRIC]
            made[: len(own)] += images * own.reshape(len(own), -1) @ parts.warming.displacement
        return work[:, :-1], made
