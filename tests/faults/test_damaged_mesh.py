"""Mesh files damaged at random, through the program: solved or refused, and nothing left behind."""

import random

import pytest
from contained import contained
from mesh_files import damaged, files_of, rod_mesh

STUDY = '[rod]\nmesh = "rod.{}"\n[material]\npreset = "leon-2001"\n'


def ended(kind, files):
    study = STUDY.format(kind).encode()
    return contained(["rod", "s.toml", "--quiet"], {"s.toml": study, **files}, seconds=120)


@pytest.mark.parametrize("kind", ["inp", "msh", "bdf", "med", "xdmf", "vtu"])
def test_a_damaged_file_is_used_or_refused(kind):
    for seed in range(2):
        found = ended(kind, damaged(kind, random.Random(f"{kind} {seed}")))  # noqa: S311
        assert not found.fault(), found
        assert "Try FEA_DEBUG" not in found.said


def test_a_file_that_unpacks_to_more_than_its_memory_is_refused():
    """Half a mebibyte that holds coordinates of gibibytes."""
    whole = files_of("inp", *rod_mesh(1))["rod.inp"]
    many = b"*NODE\n" + b"1,0,0,0\n" * 200_000 + whole
    found = ended("inp", {"rod.inp": many})
    assert found.code == 3
    assert "defined twice, at different places" in found.said
