"""Where values of a quantity lie in engines that exist: what lies far outside is in another unit."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Plausible:
    """The range of a key in engines, from model engines to those of ships; each key is in its own unit.

    A value outside of it is noted. One that is `far` times as large or small is refused.
    """

    #: least, most: bounds of the value, over the product of other keys where `of` names some
    least: float
    most: float
    why: str  #: the engines, parts or materials at the bounds
    #: Exponents of other keys: "TABLE.KEY", or "KEY" for the same table
    of: Mapping[str, float] = field(default_factory=dict)
    far: float = 2.5
    refuses_less: bool = True  #: whether a value that is too small may be refused; otherwise it is noted
    #: A key and the value below which the range holds, "" for always
    below: tuple[str, float] = ("", 0.0)
