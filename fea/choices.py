"""The fixed choices of a study and of the command line."""

from enum import StrEnum

from geometry.mirror import Mirror

# A peak stress counts as mesh-converged within this error bar, unless another tolerance is asked for: it is
# less than the uncertainty of the assumed pressure distribution or of a material's strength.
CONVERGED_PERCENT = 5.0


# Name of the bore pressure that comes from contact with the pins instead of being prescribed.
CONTACT = "contact"


class Element(StrEnum):
    """Order of the tetrahedra."""

    P1 = "p1"
    P2 = "p2"

    @property
    def order(self) -> int:
        """1 or 2."""
        return 1 if self is Element.P1 else 2


class Support(StrEnum):
    """How the rod is held."""

    INERTIA_RELIEF = "inertia-relief"
    CLAMPED = "clamped"


class Symmetry(StrEnum):
    """Part of the rod that is solved: a given mirror cell, or (auto) the smallest one that the rod has."""

    AUTO = "auto"
    NONE = Mirror.NONE.value
    HALF = Mirror.HALF.value
    QUARTER = Mirror.QUARTER.value


class SolverName(StrEnum):
    """The linear solvers."""

    AUTO = "auto"
    PARDISO = "pardiso"
    CHOLMOD = "cholmod"
    AMG = "amg"


class Assembly(StrEnum):
    """What assembles the stiffness and the nodal forces of inertia: batched kernels or scikit-fem."""

    BATCHED = "batched"
    SCIKIT_FEM = "scikit-fem"


class PinModel(StrEnum):
    """How a pin in contact gives way: as an elastic body of revolution, or not at all."""

    ELASTIC = "elastic"
    RIGID = "rigid"


class Finish(StrEnum):
    """How a part's surface was made."""

    GROUND = "ground"
    MACHINED = "machined"
    HOT_ROLLED = "hot-rolled"
    AS_FORGED = "as-forged"
    SHOT_PEENED = "shot-peened"  # a forging


class Loading(StrEnum):
    """How a part is loaded, other than the rotating-bending specimens of its endurance limit."""

    BENDING = "bending"
    AXIAL = "axial"


class Region(StrEnum):
    """Part of a rod's surface that is made in one way."""

    BORES = "bores"
    FACES = "faces"  # beside the bores, across the pins
    REST = "rest"


class Fatigue(StrEnum):
    """The mean-stress corrections for fatigue."""

    GOODMAN = "goodman"
    GERBER = "gerber"
    SODERBERG = "soderberg"
