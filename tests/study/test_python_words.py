"""Flags of messages are arguments in Python; commands of the shell stay what they are."""

import pytest

from fea.study.changes import in_python, python_words
from geometry.errors import InvalidValue
from mesh.tetmesh import MeshError


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Try a smaller --size.", "Try a smaller size=."),
        ("Use a larger --size or --solver amg", 'Use a larger size= or solver="amg"'),
        ("Add --cycle.", "Add cycle=True."),
        ("the element size and --tolerance 0.", "the element size and tolerance=0."),
        ("--tolerance 2.5 would decide", "tolerance=2.5 would decide"),
        ("(--all-cases refines for them too)", "(all_cases=True refines for them too)"),
        ("as by --cycle-accuracy exact, is", 'as by cycle_accuracy="exact", is'),
        ("as rod.cap (--cap FILE), or (--cap assumed) for", 'as rod.cap (cap=FILE), or (cap="assumed") for'),
        ("Choose another --pressure", "Choose another pressure="),
        ("write with --no-report", "write with report=False"),
        ("run `fea run x.toml --cycle`", "run `fea run x.toml --cycle`"),
        ("fea rod --fit adjusts the dimensions", "fea rod --fit adjusts the dimensions"),
        ("save it and run fea run my.toml.", "save it and run fea run my.toml."),
        ("pip install --force-reinstall gmsh", "pip install --force-reinstall gmsh"),
    ],
)
def test_a_flag_is_an_argument(text, words):
    assert in_python(text) == words


def test_errors_change_their_words_and_nothing_else():
    with pytest.raises(InvalidValue) as refused, python_words():
        raise InvalidValue("--min-safety", 0, "needs --cycle", "Add --cycle.", "an = 'example'")
    error = refused.value
    assert str(error) == "min_safety = 0: needs cycle=True. Add cycle=True."
    assert (error.name, error.value, error.rule) == ("min_safety", 0, "needs cycle=True")
    assert error.example == "an = 'example'"
    with pytest.raises(MeshError, match=r"^Try a smaller size=\.$"), python_words():
        raise MeshError("Try a smaller --size.")
