"""Studies with one value in a wrong unit, drawn at random: how many are refused, noted, or pass unnoticed.

    python tests/benchmarks/unit_mistakes.py --count 1000 --seed 1 --report results/units.md

Keys and units are drawn evenly, of studies of engines from models to ships (`tests/support/wrong_units.py`).
"""

import sys
from collections import Counter
from math import log
from pathlib import Path

from scripts import publish, reporting

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from wrong_units import ENGINES, drawn, said_of, units_of

from fea.study.plausibility import RANGES, ImplausibleValue
from fea.study.study import TABLES
from fea.study.tables import keys_of
from geometry.errors import InvalidValue

_HEAD = """# Values in a wrong unit

Made by `python tests/benchmarks/unit_mistakes.py --count {count} --seed {seed} --report results/units.md`:
studies of {engines} engines, from models of 0.8 cm³ to ship engines of 96 cm bore, and of the library's, each
with one value converted to another usual unit. Keys and units are drawn evenly. Refused is exit code 2;
noted is a line below the headline.
"""
_LEAST = 0.2
_REST = """
A wrong unit cannot be told where its factor is smaller than the span of engines. Of the values that lie
evenly (by their logarithm) in the narrowest range of their key, these shares stay within it in a wrong unit,
if they are a fifth or more; the studies above are of engines, and closer together.
"""


def main() -> None:
    """Draw, judge and count."""
    parser = reporting(__doc__)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    kinds = ("refused", "noted", "unnoticed")
    wrongs: Counter[str] = Counter()
    rights: Counter[str] = Counter()
    each: dict[str, Counter[str]] = {}
    named = 0
    for right, wrong in drawn(asked.count, asked.seed):
        before, after = said_of(right), said_of(wrong.tables)
        rights[_kind(before)] += 1
        kind = "unnoticed" if after == before else _kind(after)
        wrongs[kind] += 1
        each.setdefault(f"{wrong.key}, {wrong.unit}", Counter())[kind] += 1
        text = (
            str(after) if isinstance(after, InvalidValue) else " ".join(f"{a.key}: {a.text}" for a in after)
        )
        named += wrong.key in text and f"in {wrong.unit} (" in text
    lines = [_HEAD.format(count=asked.count, seed=asked.seed, engines=len(ENGINES))]
    lines += ["| studies | refused | noted | unnoticed |", "|---|---|---|---|"]
    for name, counts in (("in a wrong unit", wrongs), ("right", rights)):
        lines.append(f"| {name} | {' | '.join(str(counts[kind]) for kind in kinds)} |")
    lines += ["", f"The key and its unit are named in {named} of {asked.count}. What passes unnoticed:", ""]
    lines += ["| key, unit | unnoticed | of |", "|---|---|---|"]
    passed = sorted(each.items(), key=lambda item: -item[1]["unnoticed"])
    lines += [f"| {name} | {c['unnoticed']} | {c.total()} |" for name, c in passed if c["unnoticed"]]
    lines += [_REST, "| key, unit | share, % |", "|---|---|"]
    lines += [f"| {name} | {100 * share:.0f} |" for name, share in _undetectable() if share >= _LEAST]
    publish("\n".join([*lines, ""]), asked.report)


def _undetectable() -> list[tuple[str, float]]:
    """Return keys with a unit, and which part of their range the other unit leaves within it."""
    spans: dict[str, list[float]] = {}
    for table, cls in TABLES.items():
        for key in keys_of(cls):
            spans.setdefault(f"{table}.{key}", [])
            for each in RANGES.get(table, {}).get(key, ()):
                span = log(each.most / each.least)
                spans[f"{table}.{key}"].append(span)
                for other, power in each.of.items():
                    whole = other if "." in other else f"{table}.{other}"
                    spans.setdefault(whole, []).append(span / abs(power))
    shares = {
        f"{key}, {unit}": min((max(0.0, 1 - abs(log(factor)) / span) for span in own), default=1.0)
        for key, own in spans.items()
        for unit, factor in units_of(key.rpartition(".")[2]).items()
    }
    return sorted(shares.items(), key=lambda item: -item[1])


def _kind(said: InvalidValue | list[ImplausibleValue]) -> str:
    if isinstance(said, InvalidValue) or any(finding.refused for finding in said):
        return "refused"
    return "noted" if said else "unnoticed"


if __name__ == "__main__":
    main()
