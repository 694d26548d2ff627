"""What a run says of its mesh."""

from types import SimpleNamespace

import pytest

from fea.rod.meshed_rod import Meshing


def notes(straightened: int, *warnings: str, size: float = 5.0, refined: bool = False) -> tuple[str, ...]:
    """Notes as lines."""
    quality, repair = SimpleNamespace(straightened=straightened), SimpleNamespace(notes=())
    return tuple(map(str, Meshing(size, quality, repair, warnings, refined).notes(rod_length=140.0)))


@pytest.mark.parametrize(
    ("count", "says"), [(0, ()), (1, ("1 element has straight",)), (3, ("3 elements have straight",))]
)
def test_mended_elements_are_counted_in_words(count, says):
    found = notes(count)
    assert len(found) == len(says)
    assert all(note.startswith(start) for note, start in zip(found, says, strict=True))


def test_gmshs_word_on_elements_that_were_mended_afterwards_is_not_passed_on():
    distortion = "Warning: Volume mesh: worst distortion = -0.7 (avg = 0.98, 2 elements with jac. < 0)"
    assert notes(0, distortion, "Warning: something else") == ("gmsh: Warning: something else",)


def test_a_coarse_size_is_remarked_on_unless_the_mesh_was_refined():
    (note,) = notes(0, size=10.0)
    assert "2 times the default" in note
    assert notes(0, size=10.0, refined=True) == ()
