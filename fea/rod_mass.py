"""Mass properties of a study's rod, without a mesh."""

from fea.study import Study
from geometry.mass import MassProperties


def rod_mass(study: Study) -> MassProperties:
    """Return the given mass properties, or the CAD kernel's of the rod's solid.

    Raises
    ------
    InvalidValue
        The study's rod has neither masses nor dimensions.
    GeometryError
        No solid came out.
    """
    if study.rod.mass is not None:
        return study.rod.mass
    from geometry.mirror import Mirror  # noqa: PLC0415 - gmsh is loaded only where a solid is drawn
    from geometry.session import session  # noqa: PLC0415
    from geometry.solid import build  # noqa: PLC0415

    with session():
        solid = build(study.rod.solid(), Mirror.QUARTER)
    return solid.mass.times(study.material.material().density)
