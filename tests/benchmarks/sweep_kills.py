"""Effect of kill -9 on a sweep, of a rod's process, the scheduler or the program: see sweep_campaign.py."""

import os
import random
import secrets
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import psutil

CHEAP = Path(__file__).parents[1] / "support" / "cheap_sweep.py"
# Processes of a sweep have it in their environment.
MARK = "SWEEP_CAMPAIGN"
_PATIENCE = 30.0


@dataclass
class Kills:
    """Observations: when a process was killed, what the journal held, and how long others went on."""

    times: list = field(default_factory=list)
    entered: list = field(default_factory=list)
    orphans: list = field(default_factory=list)

    def add(self, journal):
        """Note a kill that has just been made."""
        self.times.append(time.time())
        self.entered.append(finished(journal))


def kill(folder, who, count, path, start_scheduler):
    """Kill at random moments, `count` times, and compare with an undisturbed sweep; return faults."""
    log, mark = folder / "log", secrets.token_hex(8)
    environment = os.environ | {"CHEAP_SECONDS": "0.1", "CHEAP_LOG": str(log), MARK: mark}
    try:
        seen = disturb(folder, who, count, partial(start, who, folder, path, start_scheduler, environment))
    finally:
        for process in marked(mark):
            process.kill()
    clean = folder / "clean"
    subprocess.run([sys.executable, CHEAP, path, clean], check=True, env=os.environ | {"CHEAP_SECONDS": "0"})
    same = (folder / "out" / "sweep.csv").read_bytes() == (clean / "sweep.csv").read_bytes()
    print("same table:", same)
    return tell(log, seen) + (not same)


def start(who, folder, path, start_scheduler, environment):
    """Start a sweep, and a scheduler if it is to be killed."""
    scheduler = start_scheduler(folder, environment) if who == "scheduler" else None
    command = [sys.executable, CHEAP, path, folder / "out", *([scheduler.address] if scheduler else [])]
    with (folder / "said").open("a") as said:
        process = subprocess.Popen(list(map(str, command)), env=environment, stdout=said, stderr=said)
    return process, scheduler, environment[MARK]


def disturb(folder, who, count, started):
    """Run a sweep until it is done, and kill meanwhile; return what was seen."""
    generator, seen, codes = random.Random(1), Kills(), Counter()  # noqa: S311 - no secret
    while not codes[0]:
        process, scheduler, mark = started()
        if generator.random() < 0.8:  # or the kill may come while it starts
            await_rod(folder / "log", process)
        while process.poll() is None:
            try:
                process.wait(generator.uniform(*((1, 3) if who == "rod" else (0, 2.5))))
            except subprocess.TimeoutExpired:
                if len(seen.times) < count and end_one(who, process, scheduler, generator, mark):
                    seen.add(folder / "out" / "sweep.sqlite")
        codes[process.returncode] += 1
        if scheduler:
            scheduler.end()
        seen.orphans.append(seconds_until_alone(mark))
    said = (folder / "said").read_text().splitlines()
    print(said[-1], f"after {len(seen.times)} kills; exit codes:", dict(codes))
    return seen


def await_rod(log, process):
    """Wait until the first rod of a process begins."""
    before = log.stat().st_size if log.exists() else 0
    while process.poll() is None and (log.stat().st_size if log.exists() else 0) == before:
        time.sleep(0.01)


def tell(log, seen):
    """Say which rods were computed again, and why; return how many should not have been."""
    lines = [line.split() for line in log.read_text().splitlines()]
    begun = Counter(web for what, web, *_ in lines if what == "begin")
    ended = Counter(web for what, web, *_ in lines if what == "end")
    wrong = sum(
        what == "begin" and web in entered and float(when) > at
        for at, entered in zip(seen.times, seen.entered, strict=True)
        for what, web, _, when in lines
    )
    print(f"{len(begun)} rods begun {begun.total()} times, {begun.total() - ended.total()} times not ended")
    print(f"ended, not entered, and computed again: {sum(number - 1 for number in ended.values())}")
    print(f"computed again although the journal had them: {wrong}")
    print(f"processes were left for at most {max(seen.orphans):.1f} s")
    return wrong


def finished(journal):
    """Return the webs of the rods that a journal has results of."""
    base = sqlite3.connect(journal) if journal.exists() else sqlite3.connect(":memory:")
    try:
        found = base.execute("SELECT json_extract(design, '$.\"rod.web_thickness_mm\"') FROM rods "
                             "WHERE state = 'done'")  # fmt: skip
        return {repr(web) for (web,) in found}
    except sqlite3.OperationalError:  # not begun yet
        return set()
    finally:
        base.close()


def end_one(who, process, scheduler, generator, mark):
    """Kill -9 one process of a sweep; return whether there was one."""
    if who == "parent":
        process.kill()
    elif who == "scheduler":
        if scheduler.own.poll() is not None:  # the sweep has not noticed yet
            return False
        scheduler.own.kill()
    else:
        found = [one for one in marked(mark) if "fea.machine.isolated" in " ".join(one.cmdline())]
        if not found:
            return False
        generator.choice(found).kill()
    return True


def marked(mark):
    """Return the processes that belong to a campaign."""
    found = []
    for process in psutil.process_iter():
        try:
            if process.environ().get(MARK) == mark and process.status() != psutil.STATUS_ZOMBIE:
                found.append(process)
        except (psutil.NoSuchProcess, psutil.AccessDenied):
            continue
    return found


def seconds_until_alone(mark):
    """Wait until no process of a campaign is left, and return for how long."""
    begin = time.monotonic()
    while left := marked(mark):
        if time.monotonic() - begin > _PATIENCE:
            raise TimeoutError(f"still there: {[process.cmdline() for process in left]}")
        time.sleep(0.05)
    return time.monotonic() - begin
