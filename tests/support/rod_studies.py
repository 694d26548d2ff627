"""Rods, alone and in parts, with their engines and loads, drawn at random."""

import dataclasses
from dataclasses import fields, replace

import numpy as np

from fea.base.choices import CONTACT, PinBody, Support
from fea.study.assembly_table import AssemblyTable
from fea.study.engine_table import EngineTable
from fea.study.option_tables import AnalysisTable, ContactTable, ForcesTable, MeshTable
from fea.study.rod_table import RodTable
from fea.study.speed_tables import SpeedTable
from fea.study.study import Study
from geometry.dimensions import ShankSection, dimensions, options
from geometry.errors import InvalidValue
from geometry.rod import Rod, proportioned
from mesh.sizing import default_size


def random_rod(
    seed: int, section: ShankSection | None = None, spread: float = 0.25, *, ribbed: bool = False
) -> Rod | InvalidValue:
    """Draw a rod: usual proportions, every dimension then scaled at random; or the refusal it met.

    Parameters
    ----------
    seed
        The same seed draws the same rod.
    section
        That of the shank, with an oil gallery in half of the rods; None: an I-section or a rectangle.
    spread
        Standard deviation of the logarithm of each dimension over the usual one.
    ribbed
        Give every rod cap bolts with rounded bosses, and one rib or two over the cap.
    """
    draw = np.random.default_rng(seed)
    length = float(np.exp(draw.uniform(np.log(40), np.log(600))))
    big = length * draw.uniform(0.2, 0.6)
    try:
        drawn = draw.choice([ShankSection.I, ShankSection.RECTANGULAR])
        rod = proportioned(length, big, big * draw.uniform(0.3, 0.9), shank_section=section or drawn)
        optional = _options(rod, draw)
        if section and np.random.default_rng([seed, 1]).random() < 0.5:
            optional["oil_gallery"] = 0.3 * rod.drilled_thickness
        if ribbed:
            optional |= _cap(rod, np.random.default_rng([seed, 2]))
        rod = proportioned(**_given(rod), **optional)
        free = dimensions()[3:]  # beyond length and bores
        changes = {name: getattr(rod, name) * float(np.exp(draw.normal(0, spread))) for name in free}
        return replace(rod, **changes)
    except InvalidValue as refusal:
        return refusal


def _given(rod: Rod) -> dict[str, object]:
    return {field.name: getattr(rod, field.name) for field in fields(Rod) if field.name not in options()}


def _cap(rod: Rod, draw: np.random.Generator) -> dict[str, float]:
    height = draw.uniform(0.1, 0.2) * rod.big_end_radius
    width = rod.big_end_width * draw.uniform(0.3, 0.7)
    cap = {"cap_bolt": 0.35 * rod.big_end_width, "cap_boss_round": 0.15 * rod.big_end_width}
    cap |= {"cap_rib": height, "cap_rib_width": width}
    return cap | ({"cap_rib_groove": min(1.8 * height, 0.65 * width)} if draw.random() < 0.5 else {})


def _options(rod: Rod, draw: np.random.Generator) -> dict[str, float]:
    """Draw what a rod may have besides, each half of the time or less."""
    sizes = {
        "small_end_crown_width": 0.6 * rod.small_end_width,
        "bushing": 0.3 * rod.small_end_ring,
        "oil_hole": 0.15 * rod.small_end_bore,
        "cap_bolt": 0.35 * rod.big_end_width,
    }
    return {name: size for name, size in sizes.items() if draw.random() < 0.4}


def random_study(seed: int, section: ShankSection | None = None) -> Study | None:
    """A random rod in a random engine at full speed; None where the rod is refused."""
    rod = random_rod(seed, section)
    return None if isinstance(rod, InvalidValue) else random_engine(seed, rod)


def random_engine(seed: int, rod: Rod) -> Study:
    """A rod in a random engine at full speed."""
    draw = np.random.default_rng(10_000 + seed)
    stroke = rod.length * draw.uniform(0.45, 0.75)
    bore = stroke * draw.uniform(0.8, 1.2)
    speed = draw.uniform(8, 20) * 30 / (stroke * 1e-3)  # from the mean piston speed, m/s
    engine = EngineTable(
        stroke_mm=float(stroke),
        bore_mm=float(bore),
        piston_mass_kg=float(1.2 * (bore / 86) ** 3 * draw.uniform(0.5, 1.0)),
        cylinders=4,
        gas="otto",
        compression_ratio=10.0,
        peak_pressure_bar=float(draw.uniform(50, 110)),
    )
    table = RodTable(rod, None, None, rod.length)
    return Study(f"random-{seed}", table, engine=engine, speed=SpeedTable(rpm=float(speed)))


def assembled_study(seed: int) -> Study | InvalidValue | None:
    """A random assembled rod on a coarse mesh, or its refusal; None where no rod or no bolts were drawn."""
    study = random_study(seed)
    if study is None or not study.rod.dimensions.cap_bolt:
        return None
    draw, rod = np.random.default_rng([seed, 191]), study.rod.dimensions
    head = rod.cap_bolt * float(draw.uniform(1.35, 1.7))

    def some(chance: float, value: float) -> float | None:
        return float(value) if draw.random() < chance else None

    shell = some(0.6, draw.uniform(0.1, 0.4) * rod.big_end_ring)
    try:
        wider = dataclasses.replace(
            rod, cap_bolt_spacing=rod.cap_bolt_spacing + head * draw.uniform(0.3, 1.0)
        )
        table = AssemblyTable(
            bolt_preload_kN=float(0.35 * rod.cap_bolt**2 * draw.uniform(0.3, 1.3)),
            bolt_head_mm=head,
            bolt_nut_mm=some(0.5, head * draw.uniform(0.85, 1.05)),
            bushing_interference_mm=some(0.7, 1.5e-3 * rod.small_end_bore * draw.random())
            if rod.bushing
            else None,
            shell_thickness_mm=shell,
            shell_interference_mm=None
            if shell is None
            else some(0.8, 1.2e-3 * rod.big_end_bore * draw.random()),
            joint_friction=some(0.8, draw.choice([0.0, 0.05, 0.15, 0.3, 0.6])),
            temperature_C=some(0.5, draw.uniform(-20, 160)),
        )
        return dataclasses.replace(
            study,
            rod=dataclasses.replace(study.rod, dimensions=wider),
            assembly=table,
            contact=ContactTable(piston_pin=PinBody(draw.choice(["elastic", "rigid"]))),
            analysis=AnalysisTable(pressure=CONTACT),
            mesh=MeshTable(size_mm=float(2 * default_size(rod.length))),
            speed=SpeedTable(float(study.speed.speeds()[0] * draw.uniform(0.2, 1.3))),
        )
    except InvalidValue as refusal:
        return refusal


PRESSURES = ("cosine-180", "cosine-120", "uniform-120", "webster")
GASES = ("otto", "motored", "none")
CLAMPED_SHARE = 0.25


def randomly_loaded(study: Study, seed: int, *, in_contact: bool = False) -> Study:
    """The rod of a study under other loads: a given pin force with the big end clamped, or another engine.

    Parameters
    ----------
    study
        Of a random rod, with an engine and dimensions.
    seed
        The same seed draws the same loads.
    in_contact
        Whether an engine presses by pins in contact, the default, and not by a pressure that is drawn.
    """
    draw = np.random.default_rng([seed, 23])
    pressure = str(draw.choice(PRESSURES))
    if draw.random() < CLAMPED_SHARE:
        rod = study.rod.dimensions
        axial = 30.0 * rod.small_end_bore * rod.small_end_width * draw.choice([-1, 1])  # 30 MPa on the bore
        across = abs(axial) * draw.uniform(-0.2, 0.2)
        clamped = AnalysisTable(support=Support.CLAMPED, pressure=pressure)
        forces = ForcesTable((float(axial), float(across)))
        return dataclasses.replace(study, engine=None, forces=forces, analysis=clamped)
    engine, rpm = study.engine, study.speed.speeds()[0]
    engine = dataclasses.replace(
        engine,
        gas=str(draw.choice(GASES)),
        piston_mass_kg=float(engine.piston_mass_kg * np.exp(draw.normal(0, 0.5))),
        pin_offset_mm=float(engine.stroke_mm * draw.uniform(-0.03, 0.03)),
        friction=float(draw.uniform(0, 0.1)),
    )
    if engine.gas == "none":
        engine = dataclasses.replace(engine, compression_ratio=None)
    if engine.gas != "otto":
        engine = dataclasses.replace(engine, peak_pressure_bar=None)
    speed = SpeedTable(rpm=float(rpm * draw.uniform(0.3, 1.2)))
    analysis = AnalysisTable(pressure=None if in_contact else pressure)
    return dataclasses.replace(study, engine=engine, speed=speed, analysis=analysis)
