"""STEP files damaged at random: read, or refused; the CAD kernel's death is not ours."""

import random
import re

import pytest

from geometry.errors import GeometryError
from geometry.imported import import_step
from geometry.presets import PRESETS
from geometry.session import session
from geometry.step_file import export_step


def damaged(text, seed):
    """Text with a few references, numbers and stretches wrong."""
    draw = random.Random(seed)  # noqa: S311
    for _ in range(draw.randint(1, 6)):
        place = draw.randrange(len(text))
        match draw.choice(["lose", "letters", "end", "reference"]):
            case "lose":
                text = text[:place] + text[place + draw.randint(1, 200) :]
            case "letters":
                letters = "".join(draw.choice("0123456789#(),.'*$eE-; ") for _ in range(5))
                text = text[:place] + letters + text[place + draw.randint(1, 5) :]
            case "end" if draw.random() < 0.2:
                text = text[:place]
            case "reference":
                found = draw.choice(list(re.finditer(r"#\d+", text)))
                text = text[: found.start()] + f"#{draw.randint(0, 900)}" + text[found.end() :]
    return text


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("step") / "rod.step"
    with session():
        export_step(PRESETS["leon-2001"], path)
    return path.read_text()


@pytest.mark.parametrize("seed", range(12))
def test_a_damaged_file_is_read_or_refused(whole, tmp_path, seed):
    path = tmp_path / "damaged.step"
    path.write_text(damaged(whole, seed))
    try:
        with session():
            import_step(path)
    except GeometryError as error:
        refusal = str(error)
        assert "damaged.step" in refusal or "bore" in refusal or "solid" in refusal
