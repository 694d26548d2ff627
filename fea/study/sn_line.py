"""The S–N line of a study's material: by Basquin's constants, or fitted to tests."""

import numpy as np

from fea.material import Basquin
from geometry.invalid import InvalidValue, require, require_number, require_positive

_LINE = ("fatigue_strength_coefficient_MPa", "fatigue_strength_exponent")
_TESTS = ("sn_cycles", "sn_amplitude_MPa")
SN_KEYS = (*_LINE, *_TESTS)
# Of metals b is −0.05 to −0.15; a line that is flatter or steeper than these has another unit or sign.
_FLATTEST, _STEEPEST = -0.02, -0.5


def sn_line(
    coefficient: float | None,
    exponent: float | None,
    cycles: tuple[float, ...] | None,
    amplitudes: tuple[float, ...] | None,
) -> Basquin | None:
    """Return the line of σ_f′ (MPa) and b, or of tests: cycles to failure and amplitudes, MPa.

    Raises
    ------
    InvalidValue
        Values are missing, out of range or given in two ways.
    """
    for keys, pair in ((_LINE, (coefficient, exponent)), (_TESTS, (cycles, amplitudes))):
        for key, other, value, beside in zip(keys, keys[::-1], pair, pair[::-1], strict=True):
            complete = value is not None or beside is None
            require(complete, f"material.{key}", None, f"is missing: {other} is given", "Give both.")
    tests, line = cycles is not None, coefficient is not None
    rule = "cannot be combined with fatigue_strength_coefficient_MPa and fatigue_strength_exponent"
    require(not (tests and line), "material.sn_cycles", cycles, rule, "Keep the constants or the tests.")
    if coefficient is not None and exponent is not None:
        require_positive(f"material.{_LINE[0]}", coefficient)
        require_number(f"material.{_LINE[1]}", exponent)
        _require_slope(_LINE[1], exponent, exponent)
        return Basquin(coefficient, exponent)
    return None if cycles is None or amplitudes is None else fitted(cycles, amplitudes)


def fitted(cycles: tuple[float, ...], amplitudes: tuple[float, ...]) -> Basquin:
    """Fit Basquin's line to specimens that broke, the logarithm of life being dependent (ASTM E739).

    Raises
    ------
    InvalidValue
        There are fewer than two amplitudes, or life does not fall as they rise.
    """
    for key, values in zip(_TESTS, (cycles, amplitudes), strict=True):
        for value in values:
            require_positive(f"material.{key}", value)
    same, rule = len(cycles) == len(amplitudes), f"must have as many values as sn_cycles ({len(cycles)})"
    require(same, "material.sn_amplitude_MPa", list(amplitudes), rule)
    several, rule = len(set(amplitudes)) > 1, "must contain two amplitudes that differ, or more"
    require(several, "material.sn_amplitude_MPa", list(amplitudes), rule)
    x, y = np.log(amplitudes), np.log(cycles)
    steepness = float(np.sum((x - x.mean()) * (y - y.mean())) / np.sum((x - x.mean()) ** 2))
    if steepness >= 0:
        rule = "must fall as sn_amplitude_MPa rises"
        raise InvalidValue("material.sn_cycles", list(cycles), rule, "Check the order of both lists.")
    exponent = 1 / steepness
    _require_slope("sn_cycles", list(cycles), exponent)
    # ln N = ȳ + (x − x̄)/b, and σ_a = σ_f′ (2N)^b.
    return Basquin(float(np.exp(x.mean() - exponent * (y.mean() + np.log(2)))), exponent)


def _require_slope(key: str, value: object, exponent: float) -> None:
    given = "" if value == exponent else f"gives an exponent of {exponent:.3g}, which "
    rule = f"{given}must lie between {_STEEPEST:g} and {_FLATTEST:g}"
    require(_STEEPEST <= exponent <= _FLATTEST, f"material.{key}", value, rule, "Check its sign and units.")
