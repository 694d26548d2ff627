"""What a report is made from, wherever the run is: in memory or on disk."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy.typing as npt

from fea.analysis.cycle_figures import EnvelopeFigures
from fea.analysis.figures import Summary
from fea.analysis.motion import Motion
from fea.output.report.bores import DrawnBore
from fea.study.study import Study
from mesh.tetmesh import TetMesh

Array = npt.NDArray[Any]
Arrays = Mapping[str, Array]


@dataclass(frozen=True, kw_only=True)
class Reported:
    """A run as a report needs it.

    Attributes
    ----------
    study, summary
        What was asked, and the figures found.
    mesh
        The whole rod, mm; None where the run has no fields.
    cases
        Nodal arrays of each load case, by their names in its VTU file.
    envelope
        Those of the whole crank cycle; None without it.
    forces
        The columns of ``loads.csv``; None where forces are given.
    contact
        The columns of ``contact.csv``; None where there is no contact over the cycle.
    bores
        The two bores, the big end's first; empty where they were not found.
    motion
        The surface at every crank angle; None where it was not worked out.
    without_motion
        Why not, where the cycle was analysed; empty otherwise.
    picture
        A still picture (PNG) of the worst load case; None where this machine cannot draw.
    """

    study: Study
    summary: Summary
    mesh: TetMesh | None = None
    cases: Mapping[str, Arrays] = field(default_factory=dict)
    envelope: Arrays | None = None
    forces: Arrays | None = None
    contact: Arrays | None = None
    bores: tuple[DrawnBore, ...] = ()
    motion: Motion | None = None
    without_motion: str = ""
    picture: bytes | None = None

    @property
    def cycle(self) -> EnvelopeFigures | None:
        """The figures of the whole cycle with its histories, where there are any."""
        found = self.summary.envelope
        return found if isinstance(found, EnvelopeFigures) else None
