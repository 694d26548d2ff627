"""Keys of [engine] on its cycle: strokes, the port of a two-stroke engine, rollers in place of films."""

import math
from dataclasses import dataclass

from fea.base.note import Note, assumption, omission
from fea.base.units import BAR
from fea.study.tables import StudyTable, key, one_of, within
from geometry.errors import require

# Crank angle after TDC at which the exhaust port opens, degrees: a choice. Engines for high speed open theirs
# earlier, slow ones later, which leaves more of the stroke to compression and expansion.
EXHAUST_PORT_DEG = 95.0
_TOPIC = "two-stroke"
# Ends of a rod that may run on rollers or needles.
ROLLERS = BIG, SMALL = "big end", "small end"
# Gas models without ports or crankcase.
_IDEAL, _WITHOUT = ("otto", "motored"), ("none", "boyle", "compressor")


@dataclass(frozen=True, kw_only=True)
class CycleKeys(StudyTable, table="engine"):
    """The cycle of the engine, and the bearings that it needs to have."""

    strokes: int | None = key(
        "2",
        "2: a two-stroke engine, whose cycle is one revolution, 0 to 360°, and which fires at 0°; default: 4",
        lambda name, value: require(value in (2, 4), name, value, "must be 2 or 4"),
    )
    exhaust_port_deg: float | None = key(
        "95.0",
        'after TDC, at which the exhaust port of a two-stroke opens; it shuts as far before TDC; for "otto", '
        '"motored" and the compression of a trace',
        within(1.0, 179.0, " degrees"),
    )
    roller_bearings: tuple[str, ...] = key(
        '["big end", "small end"]',
        "ends of the rod that run on rollers or needles: they have no oil film; default: none",
        one_of(ROLLERS),
        default=(),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        rule, port = "is that of a two-stroke engine", self.exhaust_port_deg
        valid = port is None or self.strokes == 2
        require(valid, "engine.exhaust_port_deg", port, rule, "Set strokes = 2, or remove it.")

    @property
    def port(self) -> float:
        """Crank angle after TDC at which the exhaust port opens, degrees."""
        return EXHAUST_PORT_DEG if self.exhaust_port_deg is None else self.exhaust_port_deg


def cycle_notes(keys: CycleKeys, gas: str, bore: float, intake: float, atmosphere: float) -> list[Note]:
    """Return what is assumed of the gas of a two-stroke engine, and what rollers leave out.

    `bore` in mm; `intake`, `atmosphere`: absolute pressures with an open port, and below the piston, MPa.
    """
    notes = [
        omission(
            f"rollers of the {end}",
            "the pin presses on the bore as a plain one does; a single roller carries more (the most loaded "
            "of Z about 4 to 5 F/Z, Sjövall), and rolling fatigue is not computed",
        )
        for end in keys.roller_bearings
    ]
    if keys.strokes != 2 or gas in _WITHOUT:
        return notes
    if gas in _IDEAL and keys.exhaust_port_deg is None:
        text = f"assumed exhaust_port_deg = {EXHAUST_PORT_DEG:g}: expansion ends there, and"
        notes.append(assumption(f"{text} compression begins as far before TDC", _TOPIC))
    if gas in _IDEAL:
        text = f"the cylinder is filled at {intake / BAR:.4g} bar while the exhaust port is open; pulses"
        notes.append(assumption(f"{text} in the ports and burned gas that remains are left out", _TOPIC))
    force = 0.1 * BAR * math.pi * bore**2 / 4
    text = (
        f"the pressure below the piston is its mean over the cycle, {atmosphere / BAR:.4g} bar "
        f"(atmosphere_bar); a crankcase that scavenges pulsates, and every 0.1 bar is {force:.3g} N on the "
        "piston"
    )
    return [*notes, assumption(text, _TOPIC)]
