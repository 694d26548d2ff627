"""Random pressure traces of four-stroke engines as sensors and programs leave them: read rightly, or refused.

    python tests/benchmarks/trace_campaign.py --count 200 --first 1

Motored and fired (Wiebe's burn, exhaust with a blow-down and waves, intake throttled to boosted), in bar,
kPa or psi, absolute or gauge, with and without a heading, with a zero that is off by up to 6 bar, noise, a
compression ratio that is told 10 % wrong, and angles that are 2° off. A trace is *right* if the zero is
within 0.2 bar and the highest gas force within 1 %, *refused* if an error names the remedy, and *wrong*
otherwise; for one whose ratio or angles are wrong, the zero may be off by 0.35 bar. Exit code 1: one is
wrong, or more than 10 % are refused of those whose unit, ratio and angles are known.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from traces import drawn, judged


def main(first, count):
    """Run the campaign; return the exit code."""
    outcomes, of_known = {"right": 0, "refused": 0, "wrong": 0}, {"right": 0, "refused": 0, "wrong": 0}
    for seed in range(first, first + count):
        one = drawn(seed)
        outcome, why = judged(one)
        outcomes[outcome] += 1
        of_known[outcome] += one.known
        if outcome != "right":
            print(f"{seed} {outcome}: {one.what}: {why}")
    print(f"all: {outcomes}; unit, ratio and angles known: {of_known}")
    return 1 if outcomes["wrong"] or of_known["refused"] > 0.1 * sum(of_known.values()) else 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--count", type=int, default=200)
    given = parser.parse_args()
    sys.exit(main(given.first, given.count))
