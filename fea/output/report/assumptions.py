"""What a run assumes and what its model leaves out, in words: each is said where it applies to this run."""

from collections.abc import Iterator

from fea.base.choices import Element, Finish, Support
from fea.base.material import Material
from fea.output.report.tables import figure
from fea.output.stored_run import Run
from fea.study.engine_table import EngineTable
from fea.study.option_tables import PINS
from fea.study.pin_models import FILM, pin_model

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
    """Return what the run assumes, by headings."""
    clamped = run.study.analysis.support is Support.CLAMPED
    said = {
        "Material": _material(run),
        "Loads": _loads(run),
        "Pins and bores": _pins(run),
        "Joint and fits": _assembled(run),
        "Support": _CLAMPED if clamped else _RELIEVED,
        "Model": _model(run),
        "Strength": _strength(run),
    }
    return {title: text for title, text in said.items() if text}


def _material(run: Run) -> str:
    tables = {name: table for name, table in run.study.part_material.items() if name not in PINS}
    main = run.study.material.material()
    said = f"Linear elastic, isotropic and homogeneous: {_constants(main)}."
    for name, table in tables.items():
        said += f" Part {name}: {_constants(table.material())}."
    largest = max(case.max_von_mises_MPa for case in run.summary.results.values())
    least = min(case.min_safety_factor for case in run.summary.results.values())
    if least < 1:
        said += (
            f" Stresses above the yield strength, here up to {figure(largest)} MPa, are those of an elastic "
            "rod: they show that the rod yields, not what happens then."
        )
    return said


def _constants(material: Material) -> str:
    return (
        f"E = {figure(material.youngs_modulus / 1000)} GPa, ν = {figure(material.poissons_ratio)}, "
        f"{figure(material.density * 1e12)} kg/m³, yield strength {figure(material.yield_strength)} MPa"
    )


def _loads(run: Run) -> str:
    engine, summary = run.study.engine, run.summary
    if engine is None or summary.rpm is None:
        return "The force on the piston pin is given; the rod is at rest, without inertia forces."
    said = (
        f"The crank turns at a constant {summary.rpm:g} rpm; crank, block and piston are rigid. Forces "
        "follow from the exact slider-crank motion with the mass properties of the meshed rod and a piston "
        f"of {figure(engine.piston_mass_kg)} kg (with rings and pin). The gas pressure is {_gas(engine)}. "
    )
    said += "Friction of the piston is left out. " if engine.friction == 0 else (
        f"The piston slides in the cylinder with a coefficient of friction of {figure(engine.friction)}. "
    )  # fmt: skip
    said += (
        "Each load case is one instant: pressure on both bores and the inertia of the rod as a body force "
        "act together."
    )
    if "gas" in summary.results:
        said += " In the case gas the highest gas pressure acts without inertia, as at low speed."
    return said


def _gas(engine: EngineTable) -> str:
    kinds = {
        "none": "zero",
        "boyle": "that of isothermal compression and expansion (Boyle)",
        "motored": "that of adiabatic compression and expansion without combustion",
        "otto": "that of an ideal Otto cycle",
    }
    name = engine.gas.replace("\\", "/").rpartition("/")[2]
    return kinds.get(engine.gas, f"the trace {name}, the same in every cycle")


def _pins(run: Run) -> str:
    name = run.summary.model.pressure
    return pin_model(name, in_parts=run.summary.assembly is not None).assumed(name)


def _assembled(run: Run) -> str:
    found = run.summary.assembly
    if found is None:
        return ""
    friction, preload = found.joint.friction, found.bolts.preload_N / 1000
    return (
        f"Rod, cap and press-fitted parts are separate bodies in contact with Coulomb friction "
        f"({friction:g} in the joint), open and slip; each bolt is a spring between its seats with "
        f"a preload of {figure(preload)} kN, and a beam whose ends follow them. Temperature "
        f"{figure(found.temperature_C)} °C."
    )


def _model(run: Run) -> str:
    model, said = run.summary.model, ""
    kind = "second-order (ten-node)" if model.element == Element.P2 else "first-order (four-node)"
    said += f"{model.elements} {kind} tetrahedra with {model.nodes} nodes. "
    if model.symmetry in _PARTS:
        said += (
            f"{_PARTS[model.symmetry]} of the rod was solved and mirrored, exactly, as the rod is symmetric. "
        )
    if run.study.rod.from_file:
        said += "Parts that touch are bonded. "
    return said + "Displacements and strains are small, so that the equations are linear."


def _strength(run: Run) -> str:
    said = "The safety factor against yielding is the yield strength over the von Mises stress."
    if run.summary.envelope is None:
        return said
    return (
        f"{said} Fatigue is judged by mean and amplitude of the signed von Mises stress over the cycle, with "
        f"the correction of {run.summary.envelope.fatigue_criterion.capitalize()}, for an unlimited life; "
        "Crossland's factor is a second opinion for stresses whose directions rotate."
    )


def limits(run: Run) -> Iterator[str]:
    """Yield what the model leaves out: what a reviewer must judge by other means."""
    yield from _joint(run)
    yield "Plastic deformation: beyond the yield strength the stresses are not those of the real rod."
    if run.summary.assembly is None:
        yield "Temperature: the material has the same constants everywhere, and nothing expands."
    else:
        yield "Differences of temperature within the rod, and how strengths and stiffness depend on it."
    residual = "Residual stresses of forging, machining or fracture splitting"
    if run.study.material.material().marin.rest.finish == Finish.SHOT_PEENED:
        residual += " (shot peening enters through the factor of the surface alone)"
    yield f"{residual}."
    yield "Vibration of the rod and of the crank train, and variation from one engine cycle to the next."
    if run.summary.model.pressure == FILM:
        in_parts = "; the film of the small end does not load the rod" if run.summary.assembly else ""
        yield f"The bending and ovalisation of the crank pin{in_parts}."
    elif not pin_model(run.summary.model.pressure).in_contact:
        yield (
            "The bending and ovalisation of the pins, clearances, and the oil film, which change the stress "
            "in the bores."
        )
    else:
        beside = ", which is computed beside and does not load the rod" if run.summary.film else ""
        yield f"Friction and the oil film between pins and bores{beside}."
    if run.summary.envelope is None:
        yield "Fatigue: only the peaks of the cycle were solved; nothing is said about the life of the rod."
    elif run.summary.life is None:
        yield "A finite life: the fatigue factors hold for an unlimited one and predict no number of cycles."
    if run.summary.buckling.modes is None:
        yield "Buckling of the solid: the shank is judged as a column, by formulas."
    if any(case.singular_max_von_mises_MPa is not None for case in run.summary.results.values()):
        yield (
            "The stress at sharp inner edges, at the border of a clamped surface or the end of a bore that a "
            "bending pin presses on, infinite in theory: the figures are those of the rest of the rod."
        )


def _joint(run: Run) -> Iterator[str]:
    if run.summary.assembly is not None:
        yield "Settling and creep of the bolted joint, and the threads and heads of its bolts."
        return
    bushing = "bushing" in run.study.part_material
    fits = "the fit of the bushing, which is bonded in place" if bushing else "bushings"
    yield (
        "The joint of the big end: cap and rod are one piece, without bolts and their preload. So are the "
        f"fits: neither bearing shells nor {fits} press on the bores."
    )
