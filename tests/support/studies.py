"""Studies, and texts of studies, that several tests share."""

from dataclasses import replace

from fea.study.study import load_study

ENGINE = """
[engine]
stroke_mm = 94.0
bore_mm = 76.0
piston_mass_kg = 1.3345
gas = "leon-2001"
"""
LEON = '\n[rod]\npreset = "leon-2001"' + ENGINE
# The same without pockets in the shank.
PLAIN = LEON.replace("[engine]", 'shank_section = "rectangular"\n[engine]', 1)
# Without contact, for tests of something else: half of the time.
PRESSED = '[analysis]\npressure = "cosine-180"\n'
# A duty at full size; tests give it coarse elements.
DUTY = f"""{LEON}[material]
preset = "forged-steel-2005"
surface = "machined"
[duty]
rpm = [4000, 6000]
share_percent = [90, 10]
"""
# A rod whose only free dimension is soon found.
OPTIMISE = """
[rod]
length_mm = 141.0
big_end_bore_mm = 50.0
small_end_bore_mm = 24.0
shank_section = "rectangular"
shank_width_mm = 16.0
[material]
preset = "leon-2001"
[forces]
pin_N = [40000.0, 0.0]
[optimise]
free = { shank_width_mm = [8.0, 20.0] }
min_yield_safety = 1.05
"""


def plain_study():
    """León's study without pockets in the shank, under prescribed pressure: a fifth of the time."""
    study = load_study("leon-2001").with_rod(shank_section="rectangular")
    return replace(study, analysis=replace(study.analysis, pressure="cosine-180"))
