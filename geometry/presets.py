"""Rods of published engines: printed figures are met as closely as one real rod can, the rest is ours."""

from types import MappingProxyType

from geometry.dimensions import ShankSection
from geometry.rod import Rod

LEON_2001 = Rod(
    length=141.0,
    big_end_bore=50.0,
    small_end_bore=24.0,
    big_end_ring=8.72,
    big_end_width=30.0,
    small_end_ring=11.60,
    small_end_width=30.0,
    shank_depth_big_end=15.45,
    shank_depth_small_end=10.46,
    shank_width=10.82,
    shank_section=ShankSection.I,
    flange_thickness=2.4,
    web_thickness=5.0,
    big_end_fillet=30.0,
    small_end_fillet=22.0,
    ring_step_radius=10.0,
    pocket_corner_radius=2.4,
    pocket_floor_radius=2.0,
    pocket_setback=4.0,
)
"""León 2001 (thesis, UNAM): a four-cylinder of two litres, stroke 94 mm.

Published: length 141 mm; mass 0.785 kg (at 7700 kg/m³: 101.95 cm³); centre of gravity 64 mm from the crank
pin; section of the shank as a column A = 0.89 cm², I = 0.126 cm⁴. There is no drawing: bores, widths, rings
and radii are ours, plausible for the engine, with ring and shank dimensions fitted to the five figures.
A and I are met at the smallest section of the shank, with I about the z axis: the thesis treats the rod as a
column with both ends pinned (K = 1), which is buckling in the plane of motion. Its "inertia" 3.868e-3 kg·m²
is the product m·a·b of the two-mass reduction, not a property of the rod, and is not a target.

Misfit of the rounded dimensions: mass +0.02 %, centre of gravity −0.02 %, A −0.03 %, I −0.02 %.
"""

FORSA_G10 = Rod(
    length=120.0,
    big_end_bore=45.0,
    small_end_bore=18.0,
    big_end_ring=7.98,
    big_end_width=22.2,
    small_end_ring=4.61,
    small_end_width=17.5,
    shank_depth_big_end=18.5,
    shank_depth_small_end=14.01,
    shank_width=13.4,
    shank_section=ShankSection.I,
    flange_thickness=3.0,
    web_thickness=4.0,
    big_end_fillet=25.0,
    small_end_fillet=18.0,
    ring_step_radius=6.0,
    pocket_corner_radius=3.0,
    pocket_floor_radius=2.0,
    pocket_setback=4.0,
)
"""Columba 2022 (thesis, ESPE Latacunga): Suzuki Forsa 1, G10, three cylinders, stroke 77 mm.

Published: length 120 mm; mass 0.384 kg, centre of gravity 31.77 mm from the crank pin, I_z = 9.397e-4 kg·m²
(the thesis uses the root of the sum of squares of three moments instead). Ours: every other dimension,
plausible for the engine, with both rings and the shank's depth fitted to the three figures at 7850 kg/m³, a
density that is also ours. Misfit of the rounded dimensions: +0.03 %, −0.05 %, +0.01 %.
"""

MOLINA_2000CC = Rod(
    length=150.0,
    big_end_bore=52.0,
    small_end_bore=22.0,
    big_end_ring=8.0,
    big_end_width=25.0,
    small_end_ring=5.5,
    small_end_width=22.0,
    shank_depth_big_end=23.0,
    shank_depth_small_end=17.0,
    shank_width=16.0,
    shank_section=ShankSection.I,
    flange_thickness=3.5,
    web_thickness=4.5,
    big_end_fillet=28.0,
    small_end_fillet=20.0,
    ring_step_radius=7.0,
    pocket_corner_radius=4.0,
    pocket_floor_radius=2.5,
    pocket_setback=4.0,
)
"""Molina et al. 2024: a four-cylinder of 2000 cm³, bore 85 mm, stroke 88 mm.

Published: length 150 mm; nothing else of the rod (the study is kinematic). Ours: a plausible rod for such an
engine, 0.569 kg at 7850 kg/m³ with its centre of gravity 47.8 mm from the crank pin.
"""

PRESETS = MappingProxyType({"leon-2001": LEON_2001, "forsa-g10": FORSA_G10, "molina-2000cc": MOLINA_2000CC})

# What is published of each, and what is ours.
ORIGINS = MappingProxyType(
    {
        "leon-2001": "León 2001 (thesis, UNAM). Published are length, mass, centre of gravity, and area and "
        "second moment of the shank's section; there is no drawing, so that bores, widths, rings and "
        "radii are assumed.",
        "forsa-g10": "Columba 2022 (thesis, ESPE Latacunga). Published are length, mass, centre of gravity "
        "and moment of inertia; every other dimension is assumed.",
        "molina-2000cc": "Molina et al. 2024. Only the length is published; all else is assumed.",
    }
)
