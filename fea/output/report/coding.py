"""Numbers for a page: quantised to 16 bits, predicted from their neighbours, deflated, in base64.

A value is low + step·q with q of 16 bits. What is stored of q is its difference, modulo 2¹⁶, from the mean of
its two parents (`fea.output.report.surface`), as an unsigned number whose lowest bit is the sign, first the
low bytes of all, then the high ones: neighbours differ little, so that most high bytes are zero.
"""

import base64
import hashlib
import json
import zlib
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from markupsafe import Markup

from fea.output.json_file import JsonObject
from geometry.arrays import Floats, Ints

LEVELS = 2**16 - 2
# Stands for a value that there is none of.
HOLE = 2**16 - 1
# More effort than this makes a file a hundredth smaller, and writing it twice as long.
_EFFORT = 5
# Columns that are coded together.
_TOGETHER = 64


@dataclass
class Packer:
    """Collects arrays; `entries` says how each is read."""

    #: In the order of the arrays: ``name``, ``kind`` and ``count``, and for values ``columns``, ``low`` and
    #: ``step``
    entries: list[JsonObject] = field(default_factory=list)
    _pieces: list[bytes] = field(default_factory=list)

    def values(self, name: str, values: Floats, parents: Ints, *, levels: int = LEVELS) -> None:
        """Add values (n,) or (n, k), NaN where there is none, in so many steps from the least to the largest.

        The columns share their step. `parents` is (n, 2), or (0, 2) for values that do not hang together.
        """
        table = values.reshape(len(values), -1)
        known = table[np.isfinite(table)]
        low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
        step = (high - low) / min(levels, LEVELS)
        scaled = np.rint((np.where(np.isfinite(table), table, low) - low) / (step or 1.0)).astype(np.int32)
        scaled[~np.isfinite(table)] = HOLE
        self._add({"name": name, "kind": "values", "low": low, "step": step}, scaled, parents)

    def steps(self, name: str, values: Floats, parents: Ints, step: float) -> None:
        """Add values (n, k) of either sign as multiples of a step, at most 2¹⁵ of it."""
        scaled = np.rint(values.reshape(len(values), -1) / step).astype(np.int32) + 2**15
        self._add({"name": name, "kind": "steps", "step": step}, scaled, parents)

    def integers(self, name: str, values: Ints) -> None:
        """Add non-negative numbers (n,) below 2³²: low bytes first."""
        flat = values.ravel().astype(np.uint32)
        self.entries.append({"name": name, "kind": "integers", "count": len(flat)})
        self._pieces.append(np.ascontiguousarray(flat.view(np.uint8).reshape(-1, 4).T).tobytes())

    def text(self) -> str:
        """Everything as text."""
        return base64.b64encode(zlib.compress(b"".join(self._pieces), _EFFORT)).decode()

    def _add(self, entry: JsonObject, scaled: npt.NDArray[np.int32], parents: Ints) -> None:
        count, columns = scaled.shape
        self.entries.append(entry | {"count": count, "columns": columns})
        for start in range(0, columns, _TOGETHER):
            own = np.ascontiguousarray(scaled[:, start : start + _TOGETHER].T)
            # Modulo 2¹⁶, with the sign in the lowest bit; of each row the low bytes, then the high ones.
            wrapped = (own - _predicted(own, parents)).astype(np.int16).astype(np.int32)
            zigzag = ((wrapped << 1) ^ (wrapped >> 31)).astype("<u2")
            bytes_ = zigzag.view(np.uint8).reshape(*zigzag.shape, 2)
            self._pieces.append(np.ascontiguousarray(np.moveaxis(bytes_, 2, 1)).tobytes())


def corner_steps(facets: Ints) -> Ints:
    """Corners (n, 3) as the distance below the next number that has not been used: 0 is a new vertex."""
    flat = facets.ravel()
    highest = np.maximum.accumulate(np.concatenate([[-1], flat[:-1]]))
    return np.asarray(highest + 1 - flat)


def _predicted(rows: npt.NDArray[np.int32], parents: Ints) -> npt.NDArray[np.int32]:
    if not len(parents):
        return np.zeros_like(rows)
    first, second = (rows[:, parent] for parent in np.maximum(parents, 0).T)
    return np.where(parents[:, 0] >= 0, (first + second) >> 1, 0).astype(np.int32)


def policy(style: str, script: str) -> str:
    """What the page may do: run its own script and style, show pictures that it holds, and nothing else."""
    scripts = f"'{_hash(script)}'" if script else "'none'"
    return (
        f"default-src 'none'; script-src {scripts}; style-src '{_hash(style)}'; img-src data:; "
        "connect-src 'none'; base-uri 'none'; form-action 'none'"
    )


def embedded_json(value: object) -> Markup:
    """JSON that cannot end the element that holds it."""
    text = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c").replace("&", "\\u0026"))  # noqa: S704 - escaped here


def _hash(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"
