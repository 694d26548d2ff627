"""Studies drawn at random over the input space, run, and their written results examined anew."""

import math
import tempfile
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
from recheck import Told, recheck
from rod_studies import random_rod

LIMITS = {"equilibrium": 1e-6, "section": 0.03, "piston": 1e-6}


def outcome(seed, section=None):
    """Outcome of a study: refused, rechecked, marked (untrusted), or what must never be.

    With a `section`, its rod is drawn from dimensions and has that shank.
    """
    from fea import run
    from fea.__main__ import exit_code
    from fea.study.study import load_study

    with tempfile.TemporaryDirectory(prefix="fea-drawn-") as scratch:
        folder = Path(scratch)
        try:
            told = written(seed, folder, section)
            figures = run(str(folder / "study.toml"), out=folder / "r")
            told = replace(told, materials=materials(load_study(str(folder / "study.toml")), told.bushing))
            if not figures["trusted"]:
                failed = [name for name, check in figures["checks"].items() if not check["pass"]]
                return {"outcome": "marked", "code": 5, "by": ", ".join(failed)}
            errors = recheck(folder / "r", told)._asdict()
        except Exception as error:  # noqa: BLE001 - a crash is a finding
            code = exit_code(error)
            kind = "crashed" if code in (None, 7) else "refused"
            return {"outcome": kind, "code": code, "by": f"{type(error).__name__}: {error}"[:300]}
    good = all(errors[name] <= limit for name, limit in LIMITS.items())
    return {"outcome": "rechecked" if good else "WRONG", **errors}


def materials(study, bushing):
    """(E, nu, density) of the rod, and of its bushing."""
    parts = ["rod", "bushing"] if bushing else ["rod"]
    return tuple((m.youngs_modulus, m.poissons_ratio, m.density) for m in study.materials(parts))


def written(seed, folder, section=None):
    """Draw a study and write it as `study.toml`, with the files it names; return what it tells.

    A fifth of the studies is harsh: each value anywhere in its range, whatever the others are; every second
    of them has a rod drawn again until its dimensions go together, and milder friction, pressure and modulus,
    or few would get past the rules. The rest
    keeps to proportions that rods and engines have, with some dimensions off them.

    Raises
    ------
    InvalidValue
        The rod drawn is refused.
    """
    from fea.study.files import toml_text

    draw, more = np.random.default_rng([seed, 11]), np.random.default_rng([seed, 12])
    harsh = seed % 5 == 4
    rod, rod_text = drawn_rod(seed, draw, folder, harsh=harsh, section=section)
    if "rod.step" in rod_text and more.random() < 0.5:
        move(folder / "rod.step", more)
    tables = {"material": drawn_material(draw, harsh=harsh)}
    if seed % 10 == 9:  # 10 to 1260 GPa in place of 0.01: strains that linear elasticity is for
        tables["material"]["E_GPa"] = 10 ** (1 + 2.1 / 5.1 * (2 + math.log10(tables["material"]["E_GPa"])))
    if rod.bushing:
        contrast = 10 ** draw.uniform(-4, 4) if harsh else draw.uniform(0.4, 1.0)
        nu = float(more.uniform(0.4, 0.4999)) if more.random() < 0.3 else 0.34
        bushing = {"E_GPa": 100.0 * contrast, "nu": nu, "density_kg_m3": 8800.0, "yield_MPa": 200.0}
        tables["material"]["bushing"] = bushing
    clamped = bool(draw.random() < 0.15)
    if draw.random() < 0.12:
        size = rod.small_end_bore**2 * draw.uniform(1, 40) * draw.choice([-1, 1])
        across = size * draw.uniform(-0.2, 0.2) if clamped and draw.random() < 0.7 else 0.0
        tables["forces"] = {"pin_N": [float(size), float(across)]}
        told = Told((), rod.big_end_bore / 2, rod.small_end_bore / 2, rod.length, rod.bushing)
    else:
        tables["engine"], rpm = drawn_engine(draw, rod, folder, harsh=harsh)
        tables["speed"] = {"rpm": rpm}
        engine = tables["engine"]
        if seed % 10 == 9:
            engine["friction"] *= 0.1
            engine.update({k: min(p, 390.0) for k, p in engine.items() if k == "peak_pressure_bar"})
        told = Told(
            (), rod.big_end_bore / 2, rod.small_end_bore / 2, rod.length, rod.bushing,
            crank_radius=engine["stroke_mm"] / 2, speed=rpm * math.pi / 30,
            offset=engine["pin_offset_mm"], friction=engine["friction"],
            piston_mass=engine["piston_mass_kg"] * 1e-3,
        )  # fmt: skip
    element = "p1" if draw.random() < 0.12 else "p2"
    usual = (0.9, 1.3) if element == "p1" else (2.0, 2.8)  # of the default size
    coarse = draw.uniform(1.2, 5.0) if harsh else draw.uniform(*usual)
    tables["mesh"] = {"size_mm": float(rod.length / 28 * coarse), "element": element}
    tables["analysis"] = drawn_analysis(draw, clamped=clamped, harsh=harsh, cycle="engine" in tables)
    if more.random() < 0.04:
        tables["analysis"]["tolerance_percent"] = float(more.uniform(5, 15))
    if (
        tables["analysis"]["solver"] == "amg" and element == "p2"
    ):  # tenfold slower than the others on meshes of this size
        tables["mesh"]["size_mm"] *= 1.6
    if "bushing" in tables["material"] and tables["material"]["bushing"]["nu"] > 0.4:  # as slow
        tables["mesh"]["size_mm"] *= 1.3
    (folder / "study.toml").write_text(f"{rod_text}\n{toml_text(tables)}")
    return replace(told, pressure=tables["analysis"]["pressure"], clamped=clamped)


def drawn_rod(seed, draw, folder, *, harsh, section=None):
    """A rod and the [rod] table that gives it."""
    from fea.study.files import toml_text
    from fea.study.rod_table import RodTable
    from geometry.presets import PRESETS
    from geometry.rod import proportioned

    kind = draw.choice(["preset", "scaled", "proportioned", "proportioned", "step"])
    if section:
        kind = "step" if kind == "step" else "proportioned"
    if harsh:
        again = range(10_000 * seed, 10_000 * seed + 200) if seed % 10 == 9 else ()
        drawn = (random_rod(one, section) for one in (seed, *again))
        rod = refusal = next(drawn)
        while isinstance(rod, Exception):
            rod = next(drawn, None)
            if rod is None:
                raise refusal
    elif kind == "preset":
        name = str(draw.choice(list(PRESETS)))
        return PRESETS[name], f'[rod]\npreset = "{name}"\n'
    elif kind == "scaled":
        rod, scale = PRESETS[str(draw.choice(list(PRESETS)))], float(np.exp(draw.uniform(-1, 1)))
        rod = varied(rod, draw, {name: scale * getattr(rod, name) for name in lengths(rod)})
    else:
        length = float(np.exp(draw.uniform(np.log(60), np.log(400))))
        big = length * draw.uniform(0.26, 0.42)
        options = drawn_options(draw)
        if section:
            options = {"shank_section": section}
        rod = proportioned(length, big, big * draw.uniform(0.38, 0.62), **options)
        if section and draw.random() < 0.5:
            rod = replace(rod, oil_gallery=0.3 * rod.drilled_thickness)
        rod = varied(with_options(rod, draw, plain=kind == "step"), draw, {})
    if kind == "step" and not harsh:
        from geometry.cad.formats import step_file
        from geometry.session import session

        with session():
            (folder / "rod.step").write_bytes(step_file(rod))
        return rod, '[rod]\nstep = "rod.step"\n'
    return rod, toml_text({"rod": RodTable(rod, None, None, rod.length).as_dict()})


def move(path, draw):
    """Turn and shift the solid of a STEP file anywhere in space."""
    import gmsh

    from geometry.session import session

    axis, center = draw.normal(size=3), draw.uniform(-500, 500, 3)
    with session():
        solids = gmsh.model.occ.importShapes(str(path))
        gmsh.model.occ.rotate(solids, *center, *axis / np.linalg.norm(axis), draw.uniform(0, 2 * np.pi))
        gmsh.model.occ.translate(solids, *draw.uniform(-500, 500, 3))
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))


def lengths(rod):
    """Names of the dimensions a rod has."""
    return [field.name for field in fields(rod) if field.type is float and getattr(rod, field.name)]


def varied(rod, draw, given):
    """The rod with up to four of its dimensions off by some percent."""
    changes = {name: given.get(name, getattr(rod, name)) for name in lengths(rod)}
    for name in draw.choice(list(changes)[3:], draw.integers(0, 5), replace=False):
        changes[str(name)] *= float(np.exp(draw.normal(0, 0.06)))
    return replace(rod, **changes)


def drawn_options(draw):
    """Section of the shank."""
    return {"shank_section": str(draw.choice(["I", "I", "rectangular"]))}


def with_options(rod, draw, *, plain):
    """The rod with what it may have besides; a `plain` one has no second part."""
    from geometry.dimensions import options
    from geometry.rod import proportioned

    sizes = {
        "small_end_crown_width": 0.6 * rod.small_end_width,
        "bushing": 0.3 * rod.small_end_ring,
        "oil_hole": 0.15 * rod.small_end_bore,
        "cap_bolt": 0.35 * rod.big_end_width,
    }
    chosen = {name: size for name, size in sizes.items() if draw.random() < 0.25}
    if plain:
        chosen.pop("bushing", None)
    along = ("oil_gallery", "shank_bore")
    left_out = set(options()).difference(along)
    given = {field.name: getattr(rod, field.name) for field in fields(rod) if field.name not in left_out}
    return proportioned(**given, **chosen)


def drawn_material(draw, *, harsh):
    """[material]."""
    if harsh:
        return {
            "E_GPa": float(10 ** draw.uniform(-2, 3.1)),
            "nu": float(draw.uniform(-0.9, 0.4999)),
            "density_kg_m3": float(10 ** draw.uniform(2, 4.3)),
            "yield_MPa": float(10 ** draw.uniform(0, 3.5)),
        }
    presets = ["leon-2001", "forged-steel-2005", "c70-2005", "hard-steel-1945", "ti-6al-4v", "al-7075-t6"]
    if draw.random() < 0.6:
        return {"preset": str(draw.choice(presets))}
    return {
        "E_GPa": float(draw.uniform(60, 220)),
        "nu": float(draw.uniform(0.2, 0.38)),
        "density_kg_m3": float(draw.uniform(1700, 8100)),
        "yield_MPa": float(draw.uniform(200, 1200)),
    }


def drawn_engine(draw, rod, folder, *, harsh):
    """[engine], and the speed, rpm."""
    ratio = draw.uniform(0.1, 0.9) if harsh else draw.uniform(0.2, 0.36)
    stroke = float(2 * ratio * rod.length)
    bore = float(rod.length * draw.uniform(0.3, 1.0) if harsh else rod.big_end_bore * draw.uniform(1.3, 2.0))
    gas = str(draw.choice(["none", "otto", "otto", "motored", "boyle", "leon-2001", "trace.csv"]))
    engine = {
        "stroke_mm": stroke,
        "bore_mm": bore,
        "piston_mass_kg": float(0.5 * (bore / 86) ** 3 * np.exp(draw.normal(0, 1.0 if harsh else 0.3))),
        "cylinders": int(draw.integers(1, 9)),
        "pin_offset_mm": float(draw.uniform(-0.3, 0.3) * rod.length * (1 if harsh else 0.1)),
        "friction": float(draw.uniform(0, 1.5 if harsh else 0.15)),
        "gas": gas,
    }
    for key in ("pin_offset_mm", "friction"):
        engine[key] *= float(draw.random() < 0.5)
    if gas in ("otto", "motored", "boyle"):
        engine["compression_ratio"] = float(draw.uniform(1.5, 25) if harsh else draw.uniform(7, 12))
    if gas == "otto":
        engine["peak_pressure_bar"] = float(draw.uniform(10, 1000) if harsh else draw.uniform(40, 120))
        if draw.random() < 0.3:
            engine["intake_pressure_bar"] = float(draw.uniform(0.3, 2.5))
    if gas == "trace.csv":
        angles = np.linspace(0, 720, int(draw.integers(5, 200)), endpoint=False)
        pressures = 60 * np.exp(-(((angles - 370) / 40) ** 2)) + draw.uniform(-0.5, 3, angles.size)
        lines = [f"{angle:.6g},{pressure:.6g}" for angle, pressure in zip(angles, pressures, strict=True)]
        (folder / gas).write_text("\n".join(["crank_deg,pressure_bar", *lines]) + "\n")
    if harsh:
        return engine, float(draw.choice([0.0, 1.0, draw.uniform(100, 9000), 20_000.0]))
    mean_piston_speed = draw.uniform(1, 25) if draw.random() < 0.95 else 0.0  # m/s
    return engine, float(min(mean_piston_speed * 30 / (stroke * 1e-3), 20_000))


def drawn_analysis(draw, *, clamped, harsh, cycle):
    """[analysis]."""
    arc = draw.uniform(1, 180) if harsh else draw.uniform(90, 180)
    pressures = [
        "cosine-180",
        "cosine-180",
        "uniform-120",
        "webster",
        f"cosine-{arc:.1f}",
        f"uniform-{arc:.1f}",
    ]
    return {
        "support": "clamped" if clamped else "inertia-relief",
        "symmetry": str(draw.choice(["auto"] * 6 + ["quarter", "half", "half", "none"])),
        "pressure": str(draw.choice(pressures)),
        "solver": str(draw.choice(["auto", "auto", "auto", "pardiso", "cholmod", "amg"])),
        "cycle": bool(cycle and draw.random() < 0.05),
    }
