"""The fixed choices of a study and of the command line."""

from enum import StrEnum

from fea.base.units import OTHER_UNITS
from geometry.surfaces import Mirror

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
    """Part of the rod that is solved: a given symmetry cell, or (auto) the smallest one that the rod has."""

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


class MatrixAssembly(StrEnum):
    """Assembly of the stiffness and of the nodal forces of inertia: batched kernels or scikit-fem."""

    BATCHED = "batched"
    SCIKIT_FEM = "scikit-fem"


class CycleAccuracy(StrEnum):
    """How exactly the cycle of a rod in contact is superposed (`fea.analysis.cycle.basis`)."""

    FAST = "fast"
    EXACT = "exact"


class UnitSystem(StrEnum):
    """The units that a reader is shown; data files are in SI units and mm whatever is shown."""

    SI = "si"
    US = "us"


class PinBody(StrEnum):
    """How a pin in contact gives way: as an elastic body of revolution, or not at all."""

    ELASTIC = "elastic"
    RIGID = "rigid"


class CapJoint(StrEnum):
    """Joint between rod and cap; an oblique one is given by its angle."""

    STRAIGHT = "straight"


class BoltGrade(StrEnum):
    """Property classes of bolts (ISO 898-1), and grades of aftermarket bolts."""

    G8_8 = "8.8"
    G9_8 = "9.8"
    G10_9 = "10.9"
    G12_9 = "12.9"
    ARP_8740 = "ARP 8740"
    ARP_2000 = "ARP 2000"
    L19 = "L19"
    CUSTOM_AGE_625 = "Custom Age 625+"


class Lubricant(StrEnum):
    """Lubrication of bolts as they are tightened."""

    MOLY = "moly"
    OIL = "oil"
    AS_DELIVERED = "as-delivered"
    DRY = "dry"


class ThreadRolled(StrEnum):
    """Whether a bolt's thread was rolled before or after its heat treatment."""

    BEFORE = "before-heat-treatment"
    AFTER = "after-heat-treatment"


class Finish(StrEnum):
    """How a part's surface was made."""

    POLISHED = "polished"  # as specimens are
    GROUND = "ground"
    MACHINED = "machined"
    HOT_ROLLED = "hot-rolled"
    AS_FORGED = "as-forged"
    SHOT_PEENED = "shot-peened"  # a forging
    MACHINED_PEENED = "machined-peened"  # a bar or billet that is machined all over and shot-peened then


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


class PressureUnit(StrEnum):
    """Units in which a pressure trace may be given."""

    BAR = "bar"
    KPA = "kPa"
    MPA = "MPa"
    PA = "Pa"
    PSI = "psi"

    @property
    def bar(self) -> float:
        """One of it in bar."""
        return OTHER_UNITS["bar"].get(self.value, 1.0)


class PressureReference(StrEnum):
    """Zero of a pressure: vacuum, or the pressure in the crankcase."""

    ABSOLUTE = "absolute"
    GAUGE = "gauge"
