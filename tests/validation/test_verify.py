"""The benchmark problems of `fea verify`, each by the source its module names.

Those that take seconds are computed on coarser meshes, with a tolerance of twice the error seen there;
the others must meet their own goals.
"""

import pytest

from fea.verify.verify import CASES

pytestmark = pytest.mark.slow


# Element size relative to the case's own, and what errors are allowed relative to its tolerances.
COARSER = {
    "le10": (1.8, 7.0),  # 1.1 % off, of 0.3 % allowed on the fine mesh
    "goodier": (2.0, 8.0),  # 0.8 % off, of 0.2 %
    "cook": (2.0, 3.0),  # 0.14 % off, of 0.2 %
    "freund": (1.4, 1.3),  # the displacement at 10° 12 % off, of 10 %
    "friction-strip": (2.0, 2.0),  # the movement left 0.95 % off, of 1 %
    "lame-fit": (1.4, 3.0),  # the pressure at the worst vertex 0.7 % off, of 0.5 %
    "le11": (1.5, 1.0),
    "measured-trends": (1.6, 1.0),
    "loaded-pin": (2.0, 7.0),  # the hoop stress at 60° 3.4 % off, of 1 %
    "bree": (1.25, 1.0),
    "notched-block": (1.4, 1.5),  # the mean stress 2.8 % off, of 2 %
    "persson": (4.0, 8.0),  # the end of contact 3.6° off, of 0.5°
    "roller": (2.0, 3.0),  # the width of contact 2.9 % off, of 2 %
}


def quantities_of(name):
    """The quantities of a case, each within its tolerance."""
    case = CASES[name]
    factor, allowance = COARSER.get(name, (1.0, 1.0))
    quantities = [row.quantity for row in case.rows(factor)]
    assert case.title
    assert case.source
    assert len({quantity.name for quantity in quantities}) == len(quantities) > 0
    for quantity in quantities:
        assert quantity.why
        assert quantity.target
        assert 0 < quantity.tolerance_percent <= 10
        assert abs(quantity.error_percent) <= allowance * quantity.tolerance_percent, quantity.name
    return quantities


@pytest.mark.parametrize("name", [name for name in sorted(CASES) if name != "persson"])
def test_case(name):
    quantities_of(name)


@pytest.mark.parametrize("name", ["lame", "rotating-disc", "spun-up-ring"])
def test_displacements_converge(name):
    case = CASES[name]

    def error(factor):
        row = next(row for row in case.rows(factor) if row.quantity.unit in ("mm", "rad"))
        return abs(row.quantity.error_percent), row.dofs

    (coarse, few), (fine, many) = error(2.8), error(1.4)
    # With the third power of the element length, dofs^(−1/3), or faster; the second is asked for.
    assert fine < coarse * (few / many) ** (2 / 3)


def test_the_stress_where_contact_ends_converges():
    # The slope of the hoop stress is infinite there, so that the rate is one half at worst; pressures further
    # inside are better at once.
    def error(quantities):
        hoop = [abs(quantity.error_percent) for quantity in quantities if quantity.name.startswith("hoop")]
        return sum(hoop) / len(hoop)

    coarse = [row.quantity for row in CASES["persson"].rows(8.0)]
    assert error(quantities_of("persson")) < error(coarse) / 2**0.5
