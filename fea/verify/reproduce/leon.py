"""León 2001: every printed table."""

from fea.verify.reproduce import (
    leon_column,
    leon_forces,
    leon_gas,
    leon_inertia,
    leon_motion,
    leon_pin_loads,
    leon_stress,
)
from fea.verify.reproduce.leon_engine import SOURCE
from fea.verify.reproduce.table import Table

__all__ = ["SOURCE", "tables"]


def tables() -> list[Table]:
    """All tables in the order of the thesis."""
    found = [
        *leon_motion.tables(),
        leon_gas.gas(),
        *leon_inertia.tables(),
        *leon_forces.tables(),
        leon_pin_loads.pin_loads(),
        *leon_stress.tables(),
        leon_column.buckling(),
    ]
    return sorted(found, key=_number)


def _number(table: Table) -> tuple[float, str]:
    """Sort key: tables by number, then those without a number."""
    first = table.name.split(maxsplit=1)[0]
    return (float(first) if first.isdigit() else float("inf"), table.name)
