"""An M9 bolt with a nut, with any of its figures changed."""

from fea.base.choices import ThreadRolled
from fea.judge.bolt import Bolt
from fea.study.assembly_table import BoltStrength, parse_thread


def bolt(**changes):
    usual = {
        "thread": parse_thread("key", "M9x1"),
        "head_diameter": 13.0,
        "nut_diameter": 12.5,
        "engaged": 0.0,
        "grip": 40.0,
        "hole": 9.0,
        "shank_diameter": 9.0,
        "free_thread": 12.0,
        "modulus": 2.1e5,
        "counter_modulus": 2.1e5,
        "strength": BoltStrength(830.0, 940.0, 1040.0),
        "thread_friction": 0.12,
        "head_friction": 0.12,
        "rolled": ThreadRolled.BEFORE,
    }
    return Bolt(**{**usual, **changes})
