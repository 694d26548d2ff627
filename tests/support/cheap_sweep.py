"""A sweep as a process, its rods computed in milliseconds: python cheap_sweep.py SWEEP OUT [CLUSTER].

CHEAP_SECONDS is the time of a rod; CHEAP_LOG a file to which each rod adds a line as it begins and another as
it ends. Rods whose web is thicker than CHEAP_REFUSED, CHEAP_FATAL or CHEAP_ENDLESS raise an error, crash or
never end; CHEAP_MINUTES is the limit of a rod.
"""

import os
import signal
import sys
import time
from pathlib import Path


def compute(study, _extras):
    web = study.rod.dimensions.web_thickness
    note("begin", web)
    time.sleep(float(os.environ.get("CHEAP_SECONDS", "0.02")))
    if thicker(web, "CHEAP_FATAL"):
        os.kill(os.getpid(), signal.SIGSEGV)
    while thicker(web, "CHEAP_ENDLESS"):
        time.sleep(0.1)
    if thicker(web, "CHEAP_REFUSED"):
        raise ValueError("too thick for this test")
    note("end", web)
    return {rpm: {"factor": web / 5, "mass_kg": 0.1 * web, "trusted": True} for rpm in study.speeds()}


def thicker(web, limit):
    return web > float(os.environ.get(limit, "inf"))


def note(what, web):
    if log := os.environ.get("CHEAP_LOG"):
        with Path(log).open("a") as file:
            file.write(f"{what} {web!r} {os.getpid()} {time.time()}\n")


def main():
    from fea.apps.sweep.run_sweep import run_sweep
    from fea.apps.sweep.sweep_file import load_sweep

    address = sys.argv[3] if len(sys.argv) > 3 else None
    report = run_sweep(
        load_sweep(Path(sys.argv[1])),
        Path(sys.argv[2]),
        workers=None if address else 2,
        address=address,
        minutes=float(os.environ.get("CHEAP_MINUTES", "60")),
        compute="cheap_sweep:compute",
    )
    sys.stdout.write(f"{report.computed} {report.done} {report.failed}\n")


if __name__ == "__main__":
    main()
