"""Rods of published engines: what is printed is met as nearly as one real rod can, the rest is ours."""

from types import MappingProxyType

from geometry.rod import Rod, ShankSection

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
pin; section of the shank as a column A = 0.89 cm², I = 0.126 cm⁴. No drawing: bores, widths, rings and
radii are ours, plausible for the engine, with ring and shank dimensions fitted to the five figures.

A and I are met at the least section of the shank, I about the z axis: the thesis buckles the rod with both
ends pinned (K = 1), which is bending in the plane of motion. Its "inertia" 3.868e-3 kg·m² is the product
m·a·b of the two-mass reduction, not a property of the rod, and is not sought.

Misfit of the rounded dimensions: mass +0.02 %, centre of gravity −0.02 %, A −0.03 %, I −0.02 %.
"""

PRESETS = MappingProxyType({"leon-2001": LEON_2001})
