"""What is known and what is guessed of a contact problem: its places and loads; what touches and slips."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np

from geometry.arrays import Floats, Ints, Mask


@dataclass(frozen=True)
class Places:
    """Where parts touch, by the positions of its unknowns in `CondensedInterface.interface`."""

    normal: Ints  #: (k,) of the pressure, or of a bolt's force
    tangential: Ints  #: (k, 2) of the shear stresses; −1 where there is none
    friction: Floats  #: (k,) coefficient μ
    bolt: Mask  #: (k,) which are bolts
    rubbing: Mask  #: (k,) where friction decides on slip; elsewhere slip is given or there is no shear stress

    @property
    def size(self) -> int:
        """Number of places."""
        return len(self.normal)

    def of(self, sites: Ints) -> "Places":
        """Some of the places."""
        return Places(*(values[sites] for values in astuple(self)))

    @property
    def sticking(self) -> "Places":
        """The same places, whose slip is given."""
        return replace(self, rubbing=np.zeros_like(self.rubbing))


@dataclass(frozen=True)
class Guess:
    """What touches, opens and slips."""

    touching: Mask  #: (n_p,) which pressures of the pins act
    #: opened, slipping: (k,) which places are open; which slip
    opened: Mask
    slipping: Mask
    direction: Floats  #: (k, 2) of the shear stress where they slip
    ratio: Floats  #: (k,) friction over the length that `direction` was found from, at most 1

    def of(self, pins: Ints, sites: Ints) -> "Guess":
        """Return what it says of some pressures of the pins and some places."""
        opened, slipping = self.opened[sites], self.slipping[sites]
        return Guess(self.touching[pins], opened, slipping, self.direction[sites], self.ratio[sites])

    def equals(self, other: "Guess") -> bool:
        """Whether both say the same."""
        masks, others = ((guess.touching, guess.opened, guess.slipping) for guess in (self, other))
        if not all(map(np.array_equal, masks, others)):
            return False
        slips, of_slip = self.slipping, ((self.direction, other.direction), (self.ratio, other.ratio))
        return all(np.array_equal(one[slips], two[slips]) for one, two in of_slip)

    @classmethod
    def together(cls, n_pins: int, n_places: int, parts: Sequence[tuple[Ints, Ints, "Guess"]]) -> "Guess":
        """Put guesses of some pressures of the pins and some places together."""
        whole = cls.closed(n_pins, n_places)
        for pins, sites, part in parts:
            whole.touching[pins] = part.touching
            whole.opened[sites], whole.slipping[sites] = part.opened, part.slipping
            whole.direction[sites], whole.ratio[sites] = part.direction, part.ratio
        return whole

    @classmethod
    def closed(cls, n_pins: int, n_places: int) -> "Guess":
        """Return the state in which everything sticks and no pin touches."""
        opened, slipping = np.zeros((2, n_places), dtype=bool)
        return cls(
            np.zeros(n_pins, dtype=bool), opened, slipping, np.zeros((n_places, 2)), np.zeros(n_places)
        )


@dataclass(frozen=True)
class Offsets:
    """The sticking state under a load, without any pressure of the pins."""

    stress: Floats  #: λ_J (n_J,)
    pin_gap: Floats  #: (n_p,) moments of the gaps of the pins
    forces: Floats  #: (m,) resultants along the motions that only the pins resist
    gap: Floats  #: y_J (n_J,) at the beginning of the step
    least: float = 1e-300  #: size of the stresses elsewhere, MPa: what is little beside them is nothing

    def of(self, pins: Ints, interface: Ints, motions: Ints) -> "Offsets":
        """Offsets of some of the unknowns and motions."""
        return Offsets(
            self.stress[interface], self.pin_gap[pins], self.forces[motions], self.gap[interface], self.least
        )
