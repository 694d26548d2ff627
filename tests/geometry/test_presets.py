import pytest

from geometry.presets import LEON_2001
from geometry.section import HeightField, least_section


def test_leon_meets_every_figure_the_thesis_prints():
    # León 2001, UNAM: 0.785 kg at 7700 kg/m³, 64 mm, 0.89 cm², 0.126 cm⁴. The tolerance is that of
    # dimensions rounded to a hundredth of a millimetre.
    field = HeightField(LEON_2001)
    mass, least = field.mass(), least_section(LEON_2001)
    assert LEON_2001.length == 141
    assert mass.mass * 7700e-9 == pytest.approx(0.785, rel=5e-4)
    assert mass.center[0] == pytest.approx(64, rel=5e-4)
    assert least.area == pytest.approx(89, rel=5e-4)
    assert least.inertia_z == pytest.approx(1260, rel=5e-4)
