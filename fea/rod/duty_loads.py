"""What loads a rod at every entry of a duty."""

from dataclasses import dataclass

from fea.rod.load_cases import EngineLoading
from fea.study.duty_table import DutyTable


@dataclass(frozen=True)
class DutyLoads:
    """A duty and its loads.

    Attributes
    ----------
    table
        What the study says.
    loadings
        The engine with the gas of every entry.
    """

    table: DutyTable
    loadings: tuple[EngineLoading, ...]

    @classmethod
    def of(cls, table: DutyTable, loading: EngineLoading) -> "DutyLoads":
        """Read the gas of every entry; without any it is the engine's.

        Raises
        ------
        InvalidValue
            A gas needs a key of the engine that is missing, or a file that cannot be read.
        """
        if table.gas is None:
            return cls(table, (loading,) * len(table.rpm))
        of_gas = {gas: loading.with_gas(gas) for gas in table.gas}
        return cls(table, tuple(of_gas[gas] for gas in table.gas))
