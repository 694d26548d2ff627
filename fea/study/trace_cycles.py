"""Recorded samples of a pressure become one cycle: averaged, completed, turned to firing TDC and smoothed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Floats
from geometry.errors import InvalidValue, require

_TURN, _CYCLE, _HALF_TURN = 360.0, 720.0, 180.0
_RESET = 0.8  # of a turn: an angle that falls by this much begins again
# A revolution counts as whole within this many steps of its end.
_STEPS = 1.5
_CLOSURE = 0.05  # of the peak: how much the pressure may jump where the end of a record meets its start
_VALVES_OPEN = 30.0  # degrees about BDC in which it may jump in a lone revolution
_COARSEST = 45.0  # degrees: no gap beyond this is taken for a step
_RADIANS = 0.1
_DIGITS = 6  # of a degree, beyond which angles are the same


@dataclass(frozen=True)
class Recording:
    """Samples that cover whole revolutions."""

    angles: Floats  #: (n,) degrees in one period, increasing, from the first angle of the file on
    pressures: Floats  #: (n,) in the unit of the file: the mean of all samples at an angle
    highest: float  #: the largest single sample
    cycles: int  #: how many samples each angle has: cycles, in columns or one after the other
    period: float  #: 720, or 360 for a lone revolution or a two-stroke engine
    step: float  #: degrees between angles

    @property
    def peak(self) -> float:
        """Angle of the largest mean pressure, degrees in the file."""
        return float(self.angles[int(np.argmax(self.pressures))])


def recorded(
    angles: Floats, pressures: Floats, source: str, lines: Sequence[int], cycle: float = _CYCLE
) -> Recording:
    """Fold recorded samples into one `cycle`, degrees, or one revolution where there are no more.

    Angles (n,), degrees in the order of the file, may begin again with every revolution or cycle; pressures
    (n, m) have a column per cycle; `lines` are for messages. Raises `InvalidValue`: the angles are not
    sorted, or do not cover a revolution.
    """
    turned = _unwrapped(angles, source, lines)
    steps = np.diff(turned)
    steps = steps[steps > 0]
    require(steps.size > 1, "engine.gas", source, "must contain at least three crank angles")
    step = float(np.median(steps))
    period = _period(turned, min(float(steps.max()), _COARSEST), step, source, cycle)
    # Beyond the last whole period, samples would give some angles more weight than others.
    whole = max(1, int((turned[-1] - turned[0] + _STEPS * step) // period)) * period
    kept = turned < turned[0] + whole - 0.5 * float(steps.min())
    mean = pressures.mean(axis=1)
    at, value, count = _folded(turned[kept], mean[kept], period, step)
    cycles = int(np.median(count)) * pressures.shape[1]
    if cycles == 1 and not kept[-1] and period == cycle:
        # Refuse a cycle whose last sample, one cycle after the first, differs from it.
        gap = abs(float(mean[-1] - mean[0])) / float(np.abs(mean).max())
        rule = f"the pressures one cycle apart may differ by at most {100 * _CLOSURE:g} % of the peak"
        remedy = "Correct the drift of the pressure transducer."
        require(gap <= _CLOSURE, "engine.gas", source, f"{rule}; here {100 * gap:.3g} %", remedy)
    return Recording(at, value, float(pressures[kept].max()), cycles, period, step)


def one_cycle(
    angles: Floats, pressures: Floats, source: str, lines: Sequence[int], cycle: float = _CYCLE
) -> Recording:
    """Take samples of one cycle, (n,) and (n, 1), as they are. Raises `InvalidValue`: not sorted."""
    back = np.flatnonzero(np.diff(angles) <= 0)
    if back.size:
        after = int(back[0]) + 1
        name = f"{source}: line {lines[after]}, crank_deg"
        rule = f"must increase from line to line (it follows {angles[after - 1]:g})"
        remedy = "Sort the lines and drop repeated angles."
        raise InvalidValue(name, float(angles[after]), rule, remedy)
    return Recording(angles, pressures[:, 0], float(pressures.max()), 1, cycle, 0.0)


def _unwrapped(angles: Floats, source: str, lines: Sequence[int]) -> Floats:
    steps = np.diff(angles)
    falls = np.flatnonzero(steps < 0)
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    resets = step - steps[falls]
    turns = np.round(resets / _TURN)
    wrong = np.flatnonzero((turns < 1) | (np.abs(resets - turns * _TURN) > (1 - _RESET) * _TURN))
    if wrong.size:
        i = int(falls[wrong[0]])
        raise InvalidValue(
            f"{source} near line {lines[i + 1]}, crank angle",
            float(angles[i + 1]),
            f"must increase from line to line, or begin again after a revolution (it follows {angles[i]:g})",
            "Sort the lines by crank angle.",
        )
    added = np.zeros(angles.size)
    added[falls + 1] = turns * _TURN
    return np.asarray(angles + np.cumsum(added), dtype=np.float64)


def _period(angles: Floats, largest: float, step: float, source: str, cycle: float) -> float:
    span = float(angles[-1] - angles[0])
    if cycle - span <= _STEPS * largest:
        return cycle
    lone = abs(span + step - _TURN) <= _STEPS * step + 1e-9
    name, value = f"{source}: crank angle", f"{angles[0]:g}…{angles[-1]:g}"
    remedy = "Angles are in degrees; record whole revolutions."
    if min(abs(span + step - turn) for turn in (2 * np.pi, 4 * np.pi)) < _RADIANS:
        remedy = "These look like radians: convert them to degrees."
    whole = _TURN if span < _TURN else cycle
    of_cycle = " or a cycle of 720°" if cycle > _TURN else ""
    missing = f"must cover a revolution of 360°{of_cycle}: {whole - span - step:.4g}° are missing"
    require(lone, name, value, missing, remedy)
    return _TURN


def _folded(angles: Floats, pressures: Floats, period: float, step: float) -> tuple[Floats, Floats, Floats]:
    """Mean angle and mean pressure of the samples at each angle of a period, and how many there are."""
    inside = np.mod(angles - angles[0], period)
    steps = np.diff(angles)
    if angles[-1] - angles[0] > period and float(steps.max()) <= _STEPS * step:
        # An incremental encoder repeats its angles to within a small part of a step.
        places = max(1, round(period / step))
        place = np.round(inside * (places / period)).astype(np.int64) % places
    else:
        places_at, place = np.unique(np.round(inside, _DIGITS), return_inverse=True)
        places = places_at.size
    # Just below a whole period is the first place again.
    inside = np.where((place == 0) & (inside > period / 2), inside - period, inside)
    count = np.bincount(place, minlength=places).astype(np.float64)
    filled = count > 0
    at, value = (np.bincount(place, sums, minlength=places)[filled] for sums in (inside, pressures))
    return angles[0] + at / count[filled], value / count[filled], count[filled]


def from_firing(recording: Recording, cycle: float) -> tuple[Floats, Floats, Floats]:
    """Return angles from firing TDC, as they stand, and pressures of one cycle in the documented format."""
    if cycle == _CYCLE:
        angles = recording.angles - _TURN
        return angles, angles + _TURN, recording.pressures
    angles = _about(recording.angles, 0.0, cycle)
    order = np.argsort(angles, kind="stable")
    return angles[order], recording.angles[order], recording.pressures[order]


def completed(
    recording: Recording, firing: float, source: str, cycle: float = _CYCLE
) -> tuple[Floats, Floats, float]:
    """Return a whole cycle: angles from firing TDC, pressures, and the pressure that was assumed (else NaN).

    A lone revolution of a four-stroke engine must contain compression and expansion; the other one is held at
    the pressure with which compression begins. Firing TDC is at the angle `firing` of the file, degrees.
    Raises `InvalidValue`: the pressure jumps inside the revolution.
    """
    angles = _about(recording.angles, firing, recording.period)
    order = np.argsort(angles, kind="stable")
    at, value = angles[order], recording.pressures[order]
    if recording.period == cycle:
        return at, value, np.nan
    # Refuse a revolution whose end does not meet its start, unless that is at BDC, where valves are open.
    seam = float(recording.angles[0])
    from_firing = abs(float(_about(np.array(seam), firing, _TURN)))
    first, last = float(recording.pressures[0]), float(recording.pressures[-1])
    gap = abs(first - last) / float(np.abs(recording.pressures).max())
    rule = (
        f"the pressure jumps from {last:.4g} to {first:.4g} where the revolution ends and begins, "
        f"{from_firing:.3g}° from firing TDC: compression or expansion is missing"
    )
    open_valves = _HALF_TURN - from_firing <= _VALVES_OPEN
    require(open_valves or gap <= _CLOSURE, f"{source}: crank angle", seam, rule, "Record two revolutions.")
    start = float(value[at < at[0] + 10.0].mean())
    missing = np.arange(at[-1] + recording.step, at[0] + _CYCLE - 0.5 * recording.step, recording.step)
    return np.r_[at, missing], np.r_[value, np.full(missing.size, start)], start


def _about(angles: Floats, middle: float, period: float) -> Floats:
    """Angles from `middle`, within half a period on either side."""
    return np.asarray(np.mod(angles - middle + period / 2, period) - period / 2, dtype=np.float64)


# Degrees about a dead centre in which the peak of a firing or motored engine lies.
_EARLIEST, _LATEST = -20.0, 60.0
_SECOND = 0.8  # of the peak: another peak of this height, a revolution away, might be the firing one
_REPEATS = 0.05  # of the peak: revolutions that differ by less repeat each other


def firing_offset(recording: Recording, source: str) -> float:
    """Find what must be added to the angles of the file so that firing TDC is at 360°.

    TDC is taken to be at a multiple of 180° in the file, from 20° before to 60° after the peak. Raises
    `InvalidValue`: it is not, or both revolutions have a peak and differ.
    """
    peak = recording.peak
    tdc = np.floor((peak - _EARLIEST) / _HALF_TURN) * _HALF_TURN
    other, rule = tdc + _HALF_TURN, ""
    if peak - tdc > _LATEST:
        rule = (
            f"is not near a dead centre at a multiple of 180°: firing TDC may be at {tdc:g}°, "
            f"{peak - tdc:.4g}° before the peak, or at {other:g}°, {other - peak:.4g}° after it "
            "(if the engine was motored, some tenths of a degree after the peak)"
        )
    elif recording.period > _TURN and _fires_twice(recording, tdc):
        other = tdc + _TURN
        rule = f"and a similar one a revolution away: firing TDC may be at {tdc:g}° or at {other:g}°"
    # Above −360° and up to 360°.
    first, second = (float(_TURN - np.mod(at, _CYCLE)) for at in (tdc, other))
    remedy = f"Set engine.angle_offset_deg = {first:g} or {second:g}."
    require(not rule, f"{source}: peak pressure at", f"{peak:g}°", rule, remedy)
    return first


def _fires_twice(recording: Recording, tdc: float) -> bool:
    """Whether the other revolution has a peak as well, and does not repeat the first."""
    angles, pressures, period = recording.angles, recording.pressures, recording.period
    other = np.interp(angles + _TURN, angles, pressures, period=period)
    top, from_tdc = float(pressures.max()), np.mod(angles - tdc + _HALF_TURN, period) - _HALF_TURN
    near = (from_tdc >= _EARLIEST) & (from_tdc <= _LATEST)
    repeats = float(np.abs(other - pressures).max()) <= _REPEATS * top
    return float(other[near].max(initial=0.0)) >= _SECOND * top and not repeats


# Smoothed without being asked: samples at most this far apart whose noise is above this part of the peak.
# A mean over one degree flattens a combustion peak by p″/24, some hundredths of a percent.
_FINE_DEG, _NOISY = 0.5, 1e-3
_WIDTH_DEG = 1.0
# Not smoothed without being asked if the peak changes by more of it and by more times the noise: knocking.
_MOST_CHANGE, _MOST_NOISE = 0.01, 5.0
_SAME = 1e-3  # degrees: angles that differ by less than encoders tell apart


def smoothed(
    angles: Floats, pressures: Floats, step: float, width: float | None, cycle: float = _CYCLE
) -> tuple[Floats, float]:
    """Moving average of one cycle (n,) at `step` degrees, and its width, degrees; None: the noise decides."""
    if width:
        return _averaged(angles, pressures, width, cycle), width
    second = np.diff(pressures, n=2)
    # Standard deviation of the noise, from the median of second differences (6 σ² for white noise).
    noise = float(1.4826 * np.median(np.abs(second)) / np.sqrt(6)) if second.size else 0.0
    peak = float(np.abs(pressures).max())
    if width is None and step <= _FINE_DEG and noise > _NOISY * peak:
        averaged = _averaged(angles, pressures, _WIDTH_DEG, cycle)
        changed = abs(float(averaged.max() - pressures.max()))
        if changed <= max(_MOST_CHANGE * peak, _MOST_NOISE * noise):
            return averaged, _WIDTH_DEG
    return pressures, 0.0


def _averaged(angles: Floats, pressures: Floats, width: float, cycle: float) -> Floats:
    """Mean over the samples within half a width, as many on either side; the cycle repeats."""
    around = np.concatenate([angles - cycle, angles, angles + cycle])
    sums = np.concatenate([[0.0], np.cumsum(np.tile(pressures, 3))])
    half = width / 2 + _SAME
    first, last = np.searchsorted(around, angles - half), np.searchsorted(around, angles + half, side="right")
    middle = np.arange(angles.size) + angles.size
    beside = np.minimum(middle - first, last - 1 - middle)
    return np.asarray((sums[middle + beside + 1] - sums[middle - beside]) / (2 * beside + 1))
