"""Mesh files damaged at random, through the program: solved or refused, and nothing left behind."""

import random

import h5py
import pytest
from damage import damaged
from program import contained

pytestmark = pytest.mark.slow


STUDY = '[rod]\nmesh = "rod.{}"\n[material]\npreset = "leon-2001"\n'


def ended(kind, files):
    study = STUDY.format(kind).encode()
    return contained(["rod", "s.toml", "--quiet"], {"s.toml": study, **files}, seconds=120)


@pytest.mark.parametrize("kind", ["inp", "msh", "bdf", "med", "xdmf", "vtu"])
def test_a_damaged_file_is_used_or_refused(kind):
    found = ended(kind, damaged(kind, random.Random(kind)))  # noqa: S311
    assert not found.fault(), found


XDMF = """<Xdmf Version="3.0"><Domain><Grid Name="Grid">
<Geometry GeometryType="XYZ"><DataItem DataType="Float" Dimensions="350000000 3" Format="HDF" Precision="8">
rod.h5:/points</DataItem></Geometry>
<Topology TopologyType="Tetrahedron" NumberOfElements="1" NodesPerElement="4"><DataItem DataType="Int"
 Dimensions="1 4" Format="HDF" Precision="8">rod.h5:/tets</DataItem></Topology></Grid></Domain></Xdmf>
"""


def test_a_file_that_unpacks_to_more_than_its_share_of_memory_is_refused(tmp_path):
    """Two kibibytes that stand for eight gibibytes of coordinates."""
    with h5py.File(tmp_path / "rod.h5", "w") as file:
        file.create_dataset(
            "points", shape=(350_000_000, 3), dtype="f8", chunks=(10**6, 3), compression="gzip"
        )
        file.create_dataset("tets", data=[[0, 1, 2, 3]])
    bomb = (tmp_path / "rod.h5").read_bytes()
    assert len(bomb) < 4096
    found = ended("xdmf", {"rod.xdmf": XDMF.encode(), "rod.h5": bomb})
    assert not found.fault(), found
    assert found.code == 3
    assert "needs more than 2.0 GiB to read" in found.said
