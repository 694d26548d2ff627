"""A sweep as a process, its rods computed in milliseconds: python cheap_sweep.py SWEEP OUT [CLUSTER].

CHEAP_SECONDS is the time of a rod; CHEAP_LOG a file to which each computed rod adds a line, and CHEAP_FATAL a
file while which exists every rod ends its process.
"""

import os
import sys
import time
from pathlib import Path


def compute(study, _frequencies):
    time.sleep(float(os.environ.get("CHEAP_SECONDS", "0.02")))
    if Path(os.environ.get("CHEAP_FATAL", "/nowhere")).exists():
        os._exit(9)
    if log := os.environ.get("CHEAP_LOG"):
        with Path(log).open("a") as file:
            file.write(f"{study.rod.dimensions.web_thickness!r}\n")
    web = study.rod.dimensions.web_thickness
    if web > float(os.environ.get("CHEAP_REFUSED", "inf")):
        raise ValueError("too thick for this test")
    return {rpm: {"factor": web / 5, "mass_kg": 0.1 * web, "trusted": True} for rpm in study.speeds()}


def main():
    from fea.sweep.run_sweep import run_sweep
    from fea.sweep.sweep_file import load_sweep

    address = sys.argv[3] if len(sys.argv) > 3 else None
    report = run_sweep(
        load_sweep(Path(sys.argv[1])),
        Path(sys.argv[2]),
        workers=None if address else 2,
        address=address,
        compute=compute,
    )
    sys.stdout.write(f"{report.computed} {report.done} {report.failed}\n")


if __name__ == "__main__":
    main()
