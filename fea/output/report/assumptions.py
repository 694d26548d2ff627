"""The assumptions of a run and the limits of its model, as far as they apply to it, in sentences."""

import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from fea.base.choices import Element, Finish, Support
from fea.base.material import Material
from fea.base.note import Note, NoteKind
from fea.base.units import GPA, KG_M3, KN
from fea.output.stored_run import Run
from fea.output.units import figure, named, unit
from fea.study.engine_table import EngineTable
from fea.study.option_tables import PINS
from fea.study.pin_models import FILM, pin_model

# Keys of a study in brackets at the end of a note, and a value that is given by its key.
_KEYS = re.compile(r" \((?:\[?[a-z_]+[.\]][\w.\[\]]*|[a-z_]+_[\w]*)(?:,? (?:or |and )?[\w.\[\]]+)*\)\.?$")
_VALUE = re.compile(r"^([a-z]\w*) = ([^\s,]+)")
_SPOKEN = {"endurance_MPa": "an endurance limit", "ultimate_MPa": "an ultimate strength"}
_TOPICS = {
    "contact": "pins and bores", "assembly": "joint and fits", "fatigue": "fatigue strength",
    "film": "oil film", "map": "map of limits",
}  # fmt: skip
# Topics of assumptions that bear on a mode of failure, the first the most.
_BEARING = {
    "yielding": ("material", "engine", "gas", "contact", "assembly"),
    "fatigue": ("fatigue", "material", "engine", "gas", "contact", "assembly"),
    "buckling": ("material", "engine", "gas"),
}
_OF_BOLTS = ("bolts", "assembly", "engine", "gas", "contact")
# Of bolts, what their tightening depends on comes before their shape.
_TIGHTENING = ("preload", "friction")


class NoteGroup(NamedTuple):
    """Notes of one consequence: a heading, and lines, each with its topic or none."""

    heading: str
    lines: tuple[tuple[str, str], ...]
    folded: bool = False  #: behind its heading


def in_words(note: Note) -> str:
    """Return the text of a note without its keys, and of an assumption without the word for it."""
    text = _KEYS.sub("", note.text).removeprefix("assumed ")
    for key, words in _SPOKEN.items():
        text = text.replace(key, words)
    if (found := _VALUE.match(text)) is not None:
        words, own = named(found[1])
        text = f"{words} {found[2]} {unit(own)}".rstrip() + text[found.end() :]
    return text


def bearing(notes: Iterable[Note], mode: str) -> list[Note]:
    """Return the assumptions that bear on a mode of failure, those first that bear on it most."""
    topics = _BEARING.get(mode, _OF_BOLTS)
    rank = {note: topics.index(first) for note in notes if (first := _first(note)) in topics}
    assumed = [note for note in rank if note.kind is NoteKind.ASSUMPTION]
    return sorted(assumed, key=lambda note: (rank[note], _of_tightening(note)))


def _of_tightening(note: Note) -> int:
    return next((k for k, word in enumerate(_TIGHTENING) if word in note.text), len(_TIGHTENING))


def _first(note: Note) -> str:
    return (note.topic.split() or [""])[0]


def note_groups(notes: Iterable[Note], mode: str) -> list[NoteGroup]:
    """Return the notes in groups by consequence; assumptions that bear on the mode of failure come first."""
    every = list(notes)
    limiting = [note for note in every if note.kind in {NoteKind.DOUBT, NoteKind.WARNING}]
    first, done = bearing(every, mode), [note for note in every if note.kind is NoteKind.REMARK]
    rest = [note for note in every if note.kind is NoteKind.ASSUMPTION and note not in first]
    groups = [
        NoteGroup("What limits these figures", tuple((note.topic, in_words(note)) for note in limiting)),
        NoteGroup("Assumed, and the answer depends on it", _by_topic(first)),
        NoteGroup("Assumed beside it", _by_topic(rest), folded=True),
        NoteGroup("What was done", tuple((note.topic, in_words(note)) for note in done), folded=True),
    ]
    return [group for group in groups if group.lines]


def _by_topic(notes: Iterable[Note]) -> tuple[tuple[str, str], ...]:
    found: dict[str, list[str]] = {}
    for note in notes:
        found.setdefault(_TOPICS.get(note.topic, note.topic), []).append(in_words(note))
    return tuple((topic, "; ".join(texts)) for topic, texts in found.items())


_PARTS = {"quarter": "A quarter", "half": "A half"}
_CLAMPED = (
    "The bore of the big end is clamped, which replaces the crank pin. Stresses at the border of the clamped "
    "surface are singular and not judged."
)
_RELIEVED = (
    "Nothing is clamped (inertia relief): the loads of each case balance exactly, and displacements are "
    "given relative to the line between the bores' centres."
)


def assumptions(run: Run) -> dict[str, str]:
    """Return the assumptions of a run, by headings."""
    clamped = run.study.analysis.support is Support.CLAMPED
    texts = {
        "Material": " ".join(_material(run)),
        "Loads": " ".join(_loads(run)),
        "Pins and bores": _pins(run),
        "Joint and fits": _assembled(run),
        "Support": _CLAMPED if clamped else _RELIEVED,
        "Model": " ".join(_model(run)),
        "Strength": " ".join(_strength(run)),
    }
    return {title: text for title, text in texts.items() if text}


def _material(run: Run) -> Iterator[str]:
    parts = {name: table for name, table in run.study.part_material.items() if name not in PINS}
    yield f"Linear elastic, isotropic and homogeneous: {_constants(run.study.material.material())}."
    for name, table in parts.items():
        yield f"Part {name}: {_constants(table.material())}."
    cases = run.summary.results.values()
    if min(case.min_safety_factor for case in cases) < 1:
        largest = _amount(max(case.max_von_mises_MPa for case in cases), "MPa")
        yield (
            f"Stresses above the yield strength, here up to {largest}, are those of an elastic rod: they "
            "show that the rod yields, not what happens then."
        )


def _constants(material: Material) -> str:
    modulus = _amount(material.youngs_modulus / GPA, "GPa")
    density = _amount(material.density / KG_M3, "kg/m³")
    strength = _amount(material.yield_strength, "MPa")
    return f"E = {modulus}, ν = {figure(material.poissons_ratio)}, {density}, yield strength {strength}"


def _amount(value: float, name: str) -> str:
    return f"{figure(value, name=name)} {unit(name)}"


def _loads(run: Run) -> Iterator[str]:
    engine, summary = run.study.engine, run.summary
    if engine is None or summary.rpm is None:
        yield "The force on the piston pin is given; the rod is at rest, without inertia forces."
        return
    yield (
        f"The crank turns at a constant {summary.rpm:g} rpm; crank, block and piston are rigid. Forces "
        "follow from the exact slider-crank motion with the mass properties of the meshed rod and a piston "
        f"of {_amount(engine.piston_mass_kg, 'kg')} (with rings and pin). The gas pressure is {_gas(engine)}."
    )
    if engine.friction == 0:
        yield "Friction of the piston is left out."
    else:
        friction = figure(engine.friction)
        yield f"The piston slides in the cylinder with a coefficient of friction of {friction}."
    yield (
        "Each load case is one instant: pressure on both bores and the inertia of the rod as a body force "
        "act together."
    )
    if "gas" in summary.results:
        yield "In the case gas the highest gas pressure acts without inertia, as at low speed."


def _gas(engine: EngineTable) -> str:
    kinds = {
        "none": "zero",
        "boyle": "that of isothermal compression and expansion (Boyle)",
        "compressor": "that of an ideal compressor with clearance",
        "motored": "that of adiabatic compression and expansion without combustion",
        "otto": f"that of an ideal {'limited-pressure' if engine.fuel == 'diesel' else 'Otto'} cycle"
        f"{' of a two-stroke engine' if engine.strokes == 2 else ''}",
    }
    name = engine.gas.replace("\\", "/").rpartition("/")[2]
    return kinds.get(engine.gas, f"the trace {name}, the same in every cycle")


def _pins(run: Run) -> str:
    name = run.summary.model.pressure
    return pin_model(name, in_parts=run.summary.assembly is not None).assumed(name)


def _assembled(run: Run) -> str:
    assembly = run.summary.assembly
    if assembly is None:
        return ""
    preload, warm = _amount(assembly.bolts.preload_N / KN, "kN"), _amount(assembly.temperature_C, "°C")
    return (
        f"Rod, cap and press-fitted parts are separate bodies in contact with Coulomb friction "
        f"({assembly.joint.friction:g} in the joint), open and slip; each bolt is a spring between its seats "
        f"with a preload of {preload}, and a beam whose ends follow them. Temperature {warm}."
    )


def _model(run: Run) -> Iterator[str]:
    model = run.summary.model
    kind = "second-order (ten-node)" if model.element == Element.P2 else "first-order (four-node)"
    yield f"{model.elements} {kind} tetrahedra with {model.nodes} nodes."
    if model.symmetry in _PARTS:
        part = _PARTS[model.symmetry]
        yield f"{part} of the rod was solved and mirrored, exactly, as the rod is symmetric."
    if run.study.rod.from_file:
        yield "Parts that touch are bonded."
    yield "Displacements and strains are small, so that the equations are linear."


def _strength(run: Run) -> Iterator[str]:
    yield "The safety factor against yielding is the yield strength over the von Mises stress."
    if run.summary.envelope is not None:
        yield (
            "Fatigue is judged by mean and amplitude of the signed von Mises stress over the cycle, with the "
            f"correction of {run.summary.envelope.fatigue_criterion.capitalize()}, for an unlimited life; "
            "Crossland's factor is a second opinion for stresses whose directions rotate."
        )


def limits(run: Run) -> Iterator[str]:
    """Yield the limits of the model: what a reviewer must judge by other means."""
    summary, parts = run.summary, run.summary.assembly is not None
    if parts:
        yield "Settling and creep of the bolted joint, and the threads and heads of its bolts."
    else:
        bushing = "bushing" in run.study.part_material
        fits = "the fit of the bushing, which is bonded in place" if bushing else "bushings"
        yield (
            "The joint of the big end: cap and rod are one piece, without bolts and their preload. So are "
            f"the fits: neither bearing shells nor {fits} press on the bores."
        )
    yield "Plastic deformation: beyond the yield strength the stresses are not those of the real rod."
    if parts:
        yield "Differences of temperature within the rod, and how strengths and stiffness depend on it."
    else:
        yield "Temperature: the material has the same constants everywhere, and nothing expands."
    peened = run.study.material.material().marin.rest.finish == Finish.SHOT_PEENED
    factor = " (shot peening enters through the factor of the surface alone)" if peened else ""
    yield f"Residual stresses of forging, machining or fracture splitting{factor}."
    yield "Vibration of the rod and of the crank train; cycles of more or less pressure count in hours alone."
    if summary.model.pressure == FILM:
        in_parts = "; the film of the small end does not load the rod" if parts else ""
        yield f"The bending and ovalisation of the crank pin{in_parts}."
    elif not pin_model(summary.model.pressure).in_contact:
        yield (
            "The bending and ovalisation of the pins, clearances, and the oil film, which change the stress "
            "in the bores."
        )
    else:
        beside = ", which is computed beside and does not load the rod" if summary.film else ""
        yield f"Friction and the oil film between pins and bores{beside}."
    if summary.envelope is None:
        yield "Fatigue: only the peaks of the cycle were solved; nothing is said about the life of the rod."
    elif summary.life is None and (summary.cycle is None or summary.cycle.life is None):
        yield "A finite life: the fatigue factors hold for an unlimited one and predict no number of cycles."
    if summary.buckling.modes is None:
        yield "Buckling of the solid: the shank is judged as a column, by formulas."
    if any(case.singular_max_von_mises_MPa is not None for case in summary.results.values()):
        yield (
            "The stress at sharp inner edges, at the border of a clamped surface or the end of a bore that a "
            "bending pin presses on, infinite in theory: the figures are those of the rest of the rod."
        )
