"""What is assumed of a two-stroke engine where a study does not say it, and what its rollers leave out."""

import math
from collections.abc import Iterator

from fea.base.note import Note, assumption, omission
from fea.base.units import BAR

# Crank angle after TDC at which the exhaust port opens, degrees: a choice. Engines for high speed open theirs
# earlier, slow ones later, which leaves more of the stroke to compression and expansion.
EXHAUST_PORT_DEG = 95.0
_TOPIC = "two-stroke"
# Ends of a rod that may run on rollers or needles.
ROLLERS = BIG, SMALL = "big end", "small end"


def rollers(end: str) -> Note:
    """Return what is left out of an end that runs on rollers or needles."""
    return omission(
        f"rollers of the {end}",
        "the pin presses on the bore as a plain one does; a single roller carries more (the most loaded of Z "
        "about 4 to 5 F/Z, Sjövall), and rolling fatigue is not computed",
    )


def two_stroke_notes(
    bore: float, intake: float, atmosphere: float, port: float | None, *, computed: bool
) -> Iterator[Note]:
    """Yield what is assumed of the gas.

    `bore`: mm; `intake`, `atmosphere`: absolute pressures while the port is open and below the piston, MPa;
    `port`: degrees, None where it is not given; `computed`: whether the cycle is an ideal one.
    """
    if computed and port is None:
        assumed = f"assumed exhaust_port_deg = {EXHAUST_PORT_DEG:g}"
        yield assumption(f"{assumed}: expansion ends there, and compression begins as far before TDC", _TOPIC)
    if computed:
        open_port = f"the cylinder is at {intake / BAR:.4g} bar while the exhaust port is open"
        yield assumption(f"{open_port}; pulses in the ports are left out", _TOPIC)
    force = 0.1 * BAR * math.pi * bore**2 / 4
    text = (
        f"the pressure below the piston is its mean over the cycle, {atmosphere / BAR:.4g} bar "
        f"(atmosphere_bar); a crankcase that scavenges pulsates, and every 0.1 bar is {force:.3g} N on the "
        "piston"
    )
    yield assumption(text, _TOPIC)
