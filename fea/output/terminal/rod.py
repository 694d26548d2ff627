"""A rod's figures for a reader."""

from collections.abc import Sequence

from rich.console import Console

from fea.analysis.modes import ModesFigures
from fea.analysis.rod_report import RodReport, SolidFigures
from fea.base.note import UNITS
from fea.output.terminal.prose import print_lines, terminal, unusual
from fea.output.terminal.run_lines import plain_table

_MOST_LEFT_OUT = 3  # solids, by name


def print_rod(figures: RodReport, console: Console | None = None) -> None:
    """Print the figures of a rod."""
    console = console or terminal()
    x, y, z = figures.center_of_gravity_mm
    tensor = figures.inertia_kg_m2
    axes = [f"{2 * 'xyz'[k]} {tensor[k][k]:.4g} kg·m²" for k in range(3)]
    mesh = figures.mesh
    least, slenderness = figures.least_section, figures.slenderness
    section = f"least section {least.area_mm2:.2f} mm² at x = {least.x_mm:.1f} mm"
    in_plane = f"slenderness K l / r {slenderness['in_plane']:.1f} in the plane of motion (K = 1)"
    lines = [
        f"{figures.study}: {figures.mass_kg:.4g} kg, {figures.length_mm:.6g} mm between the bores",
        *unusual(figures.assumed),
        f"centre of gravity ({x:.2f}, {y + 0.0:.2f}, {z + 0.0:.2f}) mm from the crank pin",
        f"inertia about it: {', '.join(axes)}",
        *_found(figures),
        f"{section}, I_y {least.inertia_y_mm4:.0f} mm⁴ and I_z {least.inertia_z_mm4:.0f} mm⁴",
        f"{in_plane}, {slenderness['sideways']:.1f} sideways (K = 0.5)",
    ]
    if len(figures.parts_mm3) > 1:
        volumes = ", ".join(f"{name} {volume:.0f} mm³" for name, volume in figures.parts_mm3.items())
        lines.append(f"parts: {volumes}")
    print_lines(console, lines)
    rows = (
        (f"{one.x_mm:.1f}", f"{one.area_mm2:.1f}", f"{one.inertia_y_mm4:.0f}", f"{one.inertia_z_mm4:.0f}")
        for one in figures.sections
    )
    console.print(plain_table(("x\nmm", "area\nmm²", "I_y\nmm⁴", "I_z\nmm⁴"), rows))
    shapes = (
        f"mesh at {mesh.size_mm:.4g} mm: {mesh.nodes} nodes, {mesh.elements} elements, "
        f"symmetry {figures.symmetry}; mass within {100 * mesh.mass_error:.2g} % of the solid's; "
        f"least shape {mesh.least_shape:.2f}, least scaled Jacobian {mesh.least_scaled_jacobian:.2f}"
    )
    print_lines(console, [shapes])


def _found(figures: RodReport) -> list[str]:
    lines = []
    for name, bore in zip(("big end", "small end"), figures.bores, strict=True):
        x, y, z = bore.at_mm or (0.0, 0.0, 0.0)
        place = f" at ({x:.4g}, {y:.4g}, {z:.4g}) mm in the file" if bore.at_mm else ""
        lines.append(f"{name}: bore {bore.diameter_mm:.5g} mm, {bore.width_mm:.4g} mm long{place}")
    if figures.solids is not None and len(figures.solids) > 1:
        lines += [f"solids of the file, which is in {figures.unit}:", *solid_lines(figures.solids)]
    if figures.assembly:
        lines += ["as an assembly ([assembly] in a study):", *(f"  {text}" for text in figures.assembly)]
    return [*lines, *(str(note) for note in figures.assumed if note.topic != UNITS)]


def solid_lines(solids: Sequence[SolidFigures]) -> list[str]:
    """Return a line for each solid of a file: those that are kept, and the largest of the others."""
    ordered = sorted(solids, key=lambda solid: (not solid.kept, -solid.mass_kg))
    left = sum(not solid.kept for solid in ordered)
    lines = []
    for solid in ordered[: len(ordered) - left + _MOST_LEFT_OUT]:
        size = " x ".join(f"{length:.4g}" for length in solid.size_mm)
        kept = "" if solid.kept else ", left out"
        lines.append(f"  {solid.name}: {solid.role}{kept}; {size} mm, {solid.mass_kg:.4g} kg")
    if left > _MOST_LEFT_OUT:
        lines.append(f"  and {left - _MOST_LEFT_OUT} smaller solids, left out (--json lists them)")
    return lines


_MOST_SPEEDS = 4


def print_modes(figures: ModesFigures, console: Console | None = None) -> None:
    """Print the modes, a row each, on standard output or another console."""
    console = console or terminal()
    modes = figures.modes
    speeds = list(modes[0].orders)[:_MOST_SPEEDS]
    orders = (f"order at\n{speed.removesuffix('rpm')} rpm" for speed in speeds)
    rows = (
        (f"{n}", f"{mode.frequency_Hz:.0f}", *(f"{mode.orders[speed]:.1f}" for speed in speeds), mode.moves)
        for n, mode in enumerate(modes, start=1)
    )
    table = plain_table(("mode", "Hz", *orders, "moves mostly"), rows, left=("moves mostly",))
    print_lines(console, [f"{figures.study}: free–free vibration"], "bold")
    print_lines(console, unusual(figures.notes))
    console.print(table)
    if not figures.trusted:
        why = "there are not six rigid-body motions, or the modes do not satisfy their equation"
        print_lines(console, [f"NOT TO BE TRUSTED: {why}."])
    orders_of = "An order is the number of periods per crank revolution"
    print_lines(console, [f"{orders_of}; four-stroke engines excite half orders, too."])
