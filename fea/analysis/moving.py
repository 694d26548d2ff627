"""Rods of other dimensions on one mesh that is moved to each."""

from fea.analysis.prepare import PreparedRod, prepare
from fea.rod.discretise import moved
from fea.rod.meshed_rod import MeshedRod
from fea.study.study import Study


class MovingRod:
    """Prepares rods one after another; `base` is the mesh that is moved to each.

    The stiffness of each has the sparsity of that before, whose solver has analysed it already: a rod that is
    solved again after the next one was prepared is factorised anew.
    """

    def __init__(self, base: MeshedRod, rod: PreparedRod | None = None) -> None:
        self.base, self._last = base, rod

    def mesh(self, study: Study) -> MeshedRod | None:
        """Move the mesh to a study's rod; None where it cannot follow: see `fea.rod.discretise.moved`."""
        return moved(self.base, study.rod)

    def prepared(self, study: Study, mesh: MeshedRod) -> PreparedRod:
        """Prepare the rod of a study on the mesh that was moved to it; errors as of `prepare`."""
        symbolic = None if self._last is None else self._last.model.handed_on()
        self._last = prepare(study, mesh=mesh, symbolic=symbolic)
        return self._last

    def forget(self) -> None:
        """Let go of the last rod with its factor, which the next one would take the place of."""
        self._last = None
