"""A CAD file with a cap of its own, seen as an assembly."""

from functools import partial

from fea.machine.forked import apart
from fea.machine.guard import memory_limit
from fea.study.rod_table import RodTable
from geometry.assembly import Assembly
from geometry.errors import GeometryError
from geometry.intake import Intake, Role
from geometry.invalid import InvalidValue
from geometry.session import session


def found_assembly(rod: RodTable, intake: Intake) -> tuple[str, ...]:
    """Return the joint, bolts and interfaces of a file, in words; empty where it has no cap of its own.

    Parameters
    ----------
    rod
        The file.
    intake
        What was made of it.
    """
    if intake.assembly or rod.cad is None:
        return intake.assembly
    if not any(one.kept and one.role is Role.CAP for one in intake.members):
        return ()
    job = partial(_read, rod)
    try:
        found = job() if memory_limit() is not None else apart(job, f"read {rod.cad.path}")
    except (InvalidValue, GeometryError) as error:
        return (f"cannot be assembled with [assembly]: {error}",)
    return (*found.assembly, *(text for text in found.assumed if text not in intake.assumed))


def _read(rod: RodTable) -> Intake:
    with session():
        found = rod.draw(assembly=Assembly()).intake
    if found is None:
        raise ValueError("a solid from a file has an intake")
    return found
