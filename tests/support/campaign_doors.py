"""The doors of the campaign: ways into the program, and what must agree when a study is asked twice.

A door is a way in (a pressure trace, a CAD file, a mesh, an engine of the library, a material, a rod in
parts) or something asked of a rod (film, duty, overload, flaw, fretting, limits, sweep). Of each answer the
form is checked (`Asked`), and a relation that needs no second program: the same rod in other units, by its
own written study, drawn and from a file; twice the force, half the factor; every length s times and the
speed 1/s: the same stress; at its limit, a factor of 1. Meshes are coarse.
"""

import io
import json
import math
import re
from collections.abc import Iterator
from contextlib import chdir, redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
from campaign_studies import MATERIALS, MESHES, in_other_units, random_tables, trace_pair

from fea.__main__ import call
from fea.study.engine_library import engine_names
from fea.study.files import toml_text

Draw = np.random.Generator
Tables = dict[str, Any]
Found = dict[str, Any]
DONE, REFUSED = (0, 5, 6), (2, 3, 4)
SAME, NEAR = 1e-5, 0.02  # of one mesh; of figures whose mesh or grid differs


class RefusedError(Exception):
    """The program refused, with a clear error."""


class Asked:
    """Commands run in a folder, with what is wrong in the form of their answers."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.wrong, self.warned = folder, list[str](), list[str]()

    def study(self, name: str, tables: Tables) -> str:
        """Write a study; return its path."""
        (self.folder / f"{name}.toml").write_text(toml_text(tables), encoding="utf-8")
        return f"{name}.toml"

    def program(self, *arguments: str) -> str:
        """Run a command; return its standard output. Raises `RefusedError`: it refused."""
        said, error = io.StringIO(), io.StringIO()
        with chdir(self.folder), redirect_stdout(said), redirect_stderr(error):
            code = call(list(arguments))
        text = error.getvalue()
        if "Traceback" in text or code not in (*DONE, *REFUSED):
            self.wrong.append(f"exit code {code}: {text[-300:]}")
        if code not in DONE:
            lines = text.strip().splitlines()
            if not (1 <= len(lines) <= 4 and lines[0].startswith("fea: ")) or len(text) < 40:
                self.wrong.append(f"an error without form: {text}")
            raise RefusedError(text.strip())
        return said.getvalue()

    def run(self, name: str, tables: Tables, *flags: str) -> Found:
        """Run a study without pictures; return its summary, whose form is checked."""
        return self.run_file(self.study(name, tables), name, *flags)

    def run_file(self, path: str, name: str, *flags: str) -> Found:
        """The same of a study that is a file."""
        self.program("run", path, "--out", name, "--no-screenshot", "--quiet", *flags)
        text = (self.folder / name / "summary.json").read_text(encoding="utf-8")
        found: Found = json.loads(text, parse_constant=self._not_a_number)
        self.wrong += [f"{name}: {said}" for said in malformed(found)]
        if not found["trusted"]:
            self.warned.append(", ".join(key for key, check in found["checks"].items() if not check["pass"]))
        return found

    def read(self, *arguments: str) -> Any:
        """Run a command that prints JSON, and read it."""
        return json.loads(self.program(*arguments, "--json"), parse_constant=self._not_a_number)

    def _not_a_number(self, name: str) -> float:
        self.wrong.append(f"JSON holds {name}")
        return math.nan

    def equal(self, what: str, one: float, other: float, within: float = SAME) -> None:
        """Note where two numbers that must be equal are not."""
        if not math.isclose(one, other, rel_tol=within, abs_tol=1e-9):
            self.wrong.append(f"{what}: {one:.7g} is not {other:.7g} within {within:g}")

    def factors(self, one: Found, other: Found, ratio: float = 1.0) -> None:
        """The elastic factors of all load cases agree, once the other's are multiplied."""
        for case, result in one["results"].items():
            their = other["results"][case]
            factor = their["min_safety_factor"] * ratio
            self.equal(f"factor of {case}", result["min_safety_factor"], factor, SAME)

    def overlap(self, one: Found, other: Found) -> None:
        """The factors of all load cases agree within their error bars."""
        for case, result in one["results"].items():
            ours, theirs = (
                (found["min_safety_factor_low"], found["min_safety_factor_high"] or math.inf)
                for found in (result, other["results"][case])
            )
            if ours[0] > theirs[1] * (1 + NEAR) or theirs[0] > ours[1] * (1 + NEAR):
                self.wrong.append(f"bars of {case} are apart: {ours}, {theirs}")


def malformed(found: Any, path: str = "") -> Iterator[str]:
    """Intervals that do not hold their figure, and trust that contradicts the checks."""
    if not isinstance(found, dict):
        return
    if not path:
        if found["trusted"] != all(check["pass"] for check in found["checks"].values()):
            yield "trusted contradicts the checks"
        if not found["survival"]["text"] or "nan" in found["survival"]["text"]:
            yield f"headline {found['survival']['text']!r}"
    for key, value in found.items():
        low, high = found.get(f"{key}_low"), found.get(f"{key}_high")
        if (
            isinstance(value, (int, float))
            and low is not None
            and high is not None
            and not low <= value <= high
        ):
            yield f"{path}{key}: {value} is not in {low} … {high}"
        yield from malformed(value, f"{path}{key}.")


def trace(asked: Asked, draw: Draw) -> None:
    """One trace in two conventions: unit, zero, angles, separators, sampling."""
    tables = random_tables(draw)
    loads = []
    for name, (text, keys) in zip("ab", trace_pair(draw, tables["engine"]["compression_ratio"]), strict=True):
        (asked.folder / f"{name}.csv").write_text(text, encoding="utf-8")
        engine = {k: v for k, v in tables["engine"].items() if k != "peak_pressure_bar"}
        path = asked.study(name, tables | {"engine": engine | {"gas": f"{name}.csv"} | keys})
        loads.append(asked.read("loads", path))
    one, other = (found["trace"] for found in loads)
    asked.equal("peak of the trace", one["peak_bar"], other["peak_bar"], 0.01)
    for key in ("gas_N", "torque_Nm"):
        asked.equal(key, loads[0]["extremes"][key]["max"], loads[1]["extremes"][key]["max"], 0.015)


def cad(asked: Asked, draw: Draw) -> None:
    """A rod drawn, and from the CAD file of it."""
    tables = random_tables(draw)
    drawn = asked.run("drawn", tables, "--elastic")
    asked.program("rod", "drawn.toml", "--step", "rod.step", "--quiet")
    bores = {key: tables["rod"][key] for key in ("big_end_bore_mm", "small_end_bore_mm")}
    read = asked.run("read", tables | {"rod": {"step": "rod.step"} | bores}, "--elastic")
    asked.equal("mass", drawn["rod"]["mass_kg"], read["rod"]["mass_kg"], 2e-3)
    asked.equal("length", drawn["rod"]["length_mm"], read["rod"]["length_mm"], 1e-5)
    asked.overlap(drawn, read)


def mesh(asked: Asked, draw: Draw) -> None:
    """A rod drawn, and from the mesh that another program would be given."""
    tables = random_tables(draw)
    drawn = asked.run("drawn", tables, "--elastic")
    ending = str(draw.choice(MESHES))
    asked.program("export", "drawn", f"rod.{ending}", "--quiet")
    del tables["mesh"]
    read = asked.run("read", tables | {"rod": {"mesh": f"rod.{ending}"}}, "--elastic")
    asked.equal(f"mass by .{ending}", drawn["rod"]["mass_kg"], read["rod"]["mass_kg"], 5e-3)
    asked.overlap(drawn, read)


def engine(asked: Asked, draw: Draw) -> None:
    """An engine of the library without gas: at twice the speed, four times the inertia."""
    tables = random_tables(draw)
    preset = {"preset": str(draw.choice(engine_names())), "gas": "none"}
    rpm = float(draw.uniform(1000, 3000))
    slow, fast = (
        asked.read("loads", asked.study(f"s{k}", tables | {"engine": preset, "speed": {"rpm": k * rpm}}))
        for k in (1, 2)
    )
    for key in ("pin_axial_N", "crank_axial_N", "wall_N", "torque_Nm", "shaking_x_N"):
        for end in ("max", "min"):
            asked.equal(key, fast["extremes"][key][end], 4 * slow["extremes"][key][end], 1e-5)


def material(asked: Asked, draw: Draw) -> None:
    """A material of the library; its factors by its figures, and with a third more yield strength."""
    tables = random_tables(draw)
    preset = str(draw.choice(MATERIALS))
    found = asked.run("a", tables | {"material": {"preset": preset}}, "--elastic")
    strength = next(iter(found["results"].values()))["weakest"]["yield_MPa"]
    stronger = {"preset": preset, "yield_MPa": strength * 1.25, "ultimate_MPa": strength * 2}
    asked.factors(asked.run("b", tables | {"material": stronger}, "--elastic"), found, 1.25)


def units(asked: Asked, draw: Draw) -> None:
    """The same study in inches, pounds and psi."""
    tables = random_tables(draw)
    found = asked.run("si", tables, "--elastic")
    asked.overlap(found, other := asked.run("us", in_other_units(tables), "--elastic", "--units", "us"))
    asked.equal("mass", found["rod"]["mass_kg"], other["rod"]["mass_kg"], 1e-4)
    for case, loads in found["loads"].items():
        asked.equal(f"force of {case}", loads["pin_axial_N"], other["loads"][case]["pin_axial_N"])


def scaled(asked: Asked, draw: Draw) -> None:
    """Every length s times, the speed 1/s, masses s³: the same stress, force s², and column factor."""
    tables, scale = random_tables(draw, material={"yield_MPa": 700.0}), float(draw.uniform(0.5, 1.8))
    tables["contact"] = {"small_end_clearance_mm": 0.02, "big_end_clearance_mm": 0.05}
    larger = {
        name: {key: value * scale if key.endswith("_mm") else value for key, value in keys.items()}
        for name, keys in tables.items()
    }
    larger["engine"]["piston_mass_kg"] *= scale**3
    larger["speed"]["rpm"] /= scale
    found, other = asked.run("a", tables, "--elastic"), asked.run("b", larger, "--elastic")
    asked.overlap(found, other)  # scaled solids are meshed otherwise
    for case, loads in found["loads"].items():
        asked.equal(case, loads["crank_axial_N"] * scale**2, other["loads"][case]["crank_axial_N"], 2e-3)
    one, two = found["buckling"]["min_safety_factor"], other["buckling"]["min_safety_factor"]
    asked.equal("buckling", one, two, 2e-3)


def forces(asked: Asked, draw: Draw) -> None:
    """Twice the given force, half the factor; a transverse force mirrored, the same."""
    tables, clamped = random_tables(draw), bool(draw.random() < 0.5)
    axial = float(draw.choice([-1, 1]) * draw.uniform(5e3, 4e4))
    across = axial * float(draw.uniform(0.05, 0.2)) if clamped else 0.0
    pressure = str(draw.choice(["cosine-180", "uniform-120", "bonded", "webster"]))
    tables["analysis"] = {"pressure": pressure, "support": "clamped" if clamped else "inertia-relief"}
    del tables["engine"], tables["speed"]
    one = asked.run("a", tables | {"forces": {"pin_N": [axial, across]}}, "--elastic")
    two = asked.run("b", tables | {"forces": {"pin_N": [2 * axial, 2 * across]}}, "--elastic")
    asked.factors(one, two, 2.0)
    if clamped:
        mirrored = asked.run("c", tables | {"forces": {"pin_N": [axial, -across]}}, "--elastic")
        asked.factors(one, mirrored)


def again(asked: Asked, draw: Draw) -> None:
    """A whole cycle with flow, by its own written study: the same answer."""
    _again(asked, random_tables(draw), *(["--cycle"] if draw.random() < 0.6 else []))


def parts(asked: Asked, draw: Draw) -> None:
    """A rod in parts, by its own written study: the same answer."""
    _again(asked, random_tables(draw, bolted=True), *(["--fretting"] if draw.random() < 0.3 else []))


def film(asked: Asked, draw: Draw) -> None:
    """The oil film: thicker oil, a thicker film with less pressure; and its own study again."""
    tables = random_tables(draw)
    viscosity = float(draw.uniform(4, 12))
    thin, thick = (
        asked.run(f"v{k}", tables | {"film": {"viscosity_mPas": viscosity * k}}, "--elastic")["film"][
            "big_end"
        ]
        for k in (1, 3)
    )
    if not thick["h_min_um"] > thin["h_min_um"]:
        asked.wrong.append(f"thicker oil, thinner film: {thin['h_min_um']} µm, {thick['h_min_um']} µm")
    if not thick["power_W"] > thin["power_W"]:
        asked.wrong.append(f"thicker oil, less power: {thin['power_W']} W, {thick['power_W']} W")


def duty(asked: Asked, draw: Draw) -> None:
    """Life over a duty does not depend on the order of its rows, nor on their division."""
    tables = random_tables(draw, faster=1.5)
    del tables["speed"]
    rpm = [float(v) for v in np.round(draw.uniform(3000, 9000, 2))]
    hours = [float(v) for v in np.round(draw.uniform(10, 200, 2))]
    tables["scatter"] = {"strength_percent": float(draw.uniform(2, 12))}
    one = _life(asked, "a", tables | {"duty": {"rpm": rpm, "hours": hours}}, rpm)
    split = {"rpm": [rpm[1], rpm[0], rpm[1]], "hours": [0.25 * hours[1], hours[0], 0.75 * hours[1]]}
    two = _life(asked, "b", tables | {"duty": split}, rpm)
    for key in ("hours", "damage_per_hour"):
        if (one[key] is None) != (two[key] is None):
            asked.wrong.append(f"life.{key}: {one[key]} and {two[key]}")
        elif one[key] is not None:
            asked.equal(f"life.{key}", one[key], two[key], 1e-4)
    shares = [one["reliability"].get(f"b{share}_hours") for share in (1, 10, 50)]
    known = [value for value in shares if value is not None]
    if known != sorted(known) or None in shares[: len(known)]:
        asked.wrong.append(f"B1, B10, B50 = {shares}")


def overload(asked: Asked, draw: Draw) -> None:
    """A larger overload has a smaller factor, and sets the rod at least as much."""
    tables, force = random_tables(draw, material={"yield_MPa": 400.0}), float(draw.uniform(2e4, 6e4))
    one, two = (
        asked.run(f"f{k}", tables | {"overload": {"force_N": k * force}})["overload"] for k in (1.0, 1.4)
    )
    least, most = (
        [1.4**k * found[f"safety_factor_{end}"] for k, found in enumerate((one, two))]
        for end in ("low", "high")
    )
    if max(least) > 1.1 * min(most):
        asked.wrong.append(f"factors of an overload, times their forces: {least} to {most}")
    # Bores that are pushed come closer: their distance changes by a negative amount.
    if "set_um" in one and "set_um" in two and two["set_um"]["length"] > one["set_um"]["length"] + 0.05:
        asked.wrong.append(f"more force, less set: {one['set_um']}, {two['set_um']}")


def flaw(asked: Asked, draw: Draw) -> None:
    """A larger flaw at one place has a smaller factor."""
    tables = random_tables(draw)
    at = [0.5 * tables["rod"]["length_mm"], 0.0, 4.0]
    factors = []
    for k, depth in enumerate((0.1, 0.3, 0.6)):
        size = f"{depth}x{4 * depth:g}@" + ",".join(f"{x:g}" for x in at)
        found = asked.run(f"d{k}", tables | {"defect": {"size": size}}, "--elastic")
        factors.append(found["defect"]["factor"])
    known = [value for value in factors if value is not None]
    if known != sorted(known, reverse=True):
        asked.wrong.append(f"factors of flaws of 0.1, 0.3, 0.6 mm: {factors}")


def limits(asked: Asked, draw: Draw) -> None:
    """Run at the highest speed: the smallest factor of strength is 1 there."""
    tables = random_tables(draw)
    found = asked.read("limits", asked.study("a", tables))
    highest = found["largest_rpm"]
    if highest is None:
        return
    ran = asked.run("b", tables | {"speed": {"rpm": highest["value"]}}, "--cycle", "--elastic", "--unusual")
    keys = ("min_safety_factor", "min_fatigue_safety_factor")
    known = [ran["envelope"][key] for key in keys if ran["envelope"].get(key) is not None]
    asked.equal(
        f"at the limit ({highest['mode']})", 1.0, min([*known, ran["buckling"]["min_safety_factor"]]), 0.03
    )


def sweep(asked: Asked, draw: Draw) -> None:
    """A row of a sweep is what a run of its study says."""
    tables = random_tables(draw)
    rpm = [round(tables["speed"]["rpm"] * k) for k in (0.7, 1.0)]
    asked.study("base", tables)
    text = f'study = "base.toml"\nsampling = "grid"\nvary.speed.rpm = {rpm}\n'
    (asked.folder / "sweep.toml").write_text(text, encoding="utf-8")
    asked.program("sweep", "sweep.toml", "--workers", "1", "--out", "swept", "--quiet")
    written = asked.program("sweep", "sweep.toml", "--study", "1", "--out", "swept")
    (asked.folder / "row.toml").write_text(written, encoding="utf-8")
    ran = asked.run_file("row.toml", "row")
    head, *rows = (line.split(",") for line in (asked.folder / "swept/sweep.csv").read_text().splitlines())
    factors = [float(row[head.index("factor")]) for row in rows if row[head.index("factor")]]
    if not any(math.isclose(ran["survival"]["safety_factor"], one, rel_tol=1e-4) for one in factors):
        asked.wrong.append(f"factors of the sweep {factors}, of the run {ran['survival']['safety_factor']}")


CHEAP = (trace, cad, mesh, engine, material, units, scaled, forces, again, overload, flaw, sweep)
DOORS = (*CHEAP, parts, *CHEAP, duty, limits, *CHEAP, parts, film)


def _again(asked: Asked, tables: Tables, *flags: str) -> None:
    one = asked.run("a", tables, *flags)
    two = asked.run_file("a/study.toml", "b")
    differ = [key for key in ("survival", "results", "envelope", "assembly", "plastic", "life", "fretting")
              if _figures(one.get(key)) != _figures(two.get(key))]  # fmt: skip
    if differ:
        asked.wrong.append(f"the written study gives another {', '.join(differ)}")


def _figures(found: Any) -> str:
    return re.sub(r"(\d\.\d{4})\d*", r"\1", json.dumps(found))


def _life(asked: Asked, name: str, tables: Tables, rpm: list[float]) -> Found:
    asked.program("run", asked.study(name, tables), "--elastic", "--out", name, "--no-screenshot", "--quiet")
    path = asked.folder / name / f"{max(rpm):g}rpm" / "summary.json"
    return json.loads(path.read_text())["life"]
