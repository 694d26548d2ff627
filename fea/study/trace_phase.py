"""Firing TDC of a recorded pressure, where no key gives it."""

import numpy as np

from fea.study.trace_cycles import Recording
from geometry.invalid import InvalidValue

# Degrees about a dead centre in which the peak of a firing or motored engine lies.
_EARLIEST, _LATEST = -20.0, 60.0
_HALF_TURN, _TURN = 180.0, 360.0
_SECOND = 0.8  # of the peak: another peak of this height, a revolution away, might be the firing one
_REPEATS = 0.05  # of the peak: revolutions that differ by less repeat each other


def firing_offset(recording: Recording, source: str) -> float:
    """Find what must be added to the angles of the file so that firing TDC is at 360°.

    TDC is taken to be at a multiple of 180° in the file, where the encoder was set; the peak must lie from
    20° before to 60° after it.

    Raises
    ------
    InvalidValue
        The peak is elsewhere, or both revolutions have a peak and differ.
    """
    peak = float(recording.angles[int(np.argmax(recording.pressures))])
    before = np.floor((peak - _EARLIEST) / _HALF_TURN) * _HALF_TURN
    if peak - before > _LATEST:
        after = before + _HALF_TURN
        rule = (
            f"is not near a dead centre at a multiple of 180°: firing TDC may be at {before:g}°, "
            f"{peak - before:.4g}° before the peak, or at {after:g}°, {after - peak:.4g}° after it "
            f"(if the engine was motored, at {_axis(recording):.4g}°, about which the pressure is symmetric)"
        )
        raise _undecided(f"{source}: peak pressure at", f"{peak:g}°", rule, before, after)
    if recording.period > _TURN:
        _require_one_firing(recording, before, peak, source)
    return _offset(before)


def _axis(recording: Recording) -> float:
    """Middle of the stretch about the peak in which the pressure is above half of it."""
    i = int(np.argmax(recording.pressures))
    from_peak = np.roll(recording.pressures, recording.pressures.size // 2 - i)
    low = np.flatnonzero(from_peak < 0.5 * from_peak.max())
    middle = recording.pressures.size // 2
    rises, falls = low[low < middle], low[low > middle]
    if not (rises.size and falls.size):
        return float(recording.angles[i])
    return float(recording.angles[i] + recording.step * ((rises[-1] + falls[0]) / 2 - middle))


def _require_one_firing(recording: Recording, tdc: float, peak: float, source: str) -> None:
    """Refuse a cycle whose other revolution has a peak as well, unless that repeats the first."""
    other = np.interp(
        recording.angles + _TURN, recording.angles, recording.pressures, period=recording.period
    )
    top = float(recording.pressures.max())
    from_tdc = np.mod(recording.angles - tdc + _HALF_TURN, recording.period) - _HALF_TURN
    near = (from_tdc >= _EARLIEST) & (from_tdc <= _LATEST)
    if float(other[near].max(initial=0.0)) < _SECOND * top:
        return
    if float(np.abs(other - recording.pressures).max()) <= _REPEATS * top:
        return
    rule = f"and a similar one a revolution away: firing TDC may be at {tdc:g}° or at {tdc + _TURN:g}°"
    raise _undecided(f"{source}: peak pressure at", f"{peak:g}°", rule, tdc, tdc + _TURN)


def _undecided(name: str, value: str, rule: str, first: float, second: float) -> InvalidValue:
    remedy = f"Set engine.angle_offset_deg = {_offset(first):g} or {_offset(second):g}."
    return InvalidValue(name, value, rule, remedy)


def _offset(tdc: float) -> float:
    """The offset, above −360° and up to 360°, that brings an angle of the file to 360°."""
    return float(_TURN - np.mod(tdc, 2 * _TURN))
