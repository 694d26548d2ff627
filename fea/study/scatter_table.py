"""[scatter] of a study: what differs between rods, from which follows by when a share of them fails.

Defaults. Strength: 8 % (Stulen, Cummings & Schulte 1961, as Shigley's Mechanical Engineering Design quotes
it). Yield 7 % and ultimate strength 4 %: rolled steel in the JCSS Probabilistic Model Code (2001), part 3, as
lecture notes of ETH Zürich (Faber) print it. Pressure from cycle to cycle: 5 % (Heywood 1988, §9.4.1); that
of a diesel, of cylinders among one another and what a batch has in common are assumed. Preload, by the way of
tightening: VDI 2230, as `fea/study/bolts.toml` has it. Clearances and friction have no default.
"""

from dataclasses import dataclass

from fea.study.tables import NotNegative, Positive, StudyTable, key, within
from geometry.errors import require, require_number

_MOST = 50.0
_REMEDY = "Give a standard deviation in per cent of the mean; 0 switches it off."


def _percent(name: str, value: object) -> None:
    rule = f"must lie between 0 and {_MOST:g} %"
    require(0 <= require_number(name, value) <= _MOST, name, value, rule, _REMEDY)


_solved = within(0, 40, " %")  # two standard deviations must leave something


@dataclass(frozen=True)
class ScatterTable(
    StudyTable,
    table="scatter",
    intro="What differs between rods: standard deviations in per cent; 0 switches a cause off. Left out, the "
    "defaults count where the S-N line is known; given, B-lives are also stated of an assumed line. Switches "
    "the crank cycle on",
    optional=True,
):
    """[scatter]: None stands for a default that depends on the gas."""

    strength_percent: float = key("8.0", "of fatigue strength, log-normal", _percent, default=8.0)
    batch_percent: float = key(
        "50.0",
        "of the variance of strength is common to the rods of an engine (assumed)",
        within(0, 100, " %"),
        default=50.0,
    )
    yield_percent: float = key(
        "7.0", "of yield strength: mean stress by fatigue = soderberg", _percent, default=7.0
    )
    ultimate_percent: float = key(
        "4.0", "of ultimate strength: mean stress by goodman and gerber", _percent, default=4.0
    )
    peak_pressure_percent: float | None = key(
        "3.0", "of the mean gas load of a cylinder (assumed; 0 without combustion)", _percent
    )
    boost_percent: float = key(
        "0.0", "of the gas load of an engine, common to its rods", _percent, default=0.0
    )
    cycle_pressure_percent: float | None = key(
        "5.0",
        "of the gas load from cycle to cycle, in every rod (diesel: 1.5, assumed; 0 without combustion)",
        _percent,
    )
    preload_percent: float | None = key(
        "10.0",
        "of the preload of the bolts. The crank cycle is solved again four times, as for friction, and for "
        "clearances eight times",
        _solved,
    )
    tightening: bool = key(
        "true",
        "the usual scatter of the preload by the way of tightening (VDI 2230), if none is given",
        default=False,
    )
    friction_percent: float | None = key("20.0", "of the friction between the parts", _solved)
    clearance_um: NotNegative | None = key("3.0", "of the diametral clearance of each pin, in um")
    hours: Positive | None = key("100.0", "by which the share of rods that have failed is sought")
