"""Materials by name, in the units of a study file, each with its source.

Endurance is that of polished specimens, fully reversed; where the metal has no knee, at the number of
cycles named. Published figures of one heat: a design wants those of its own.
"""

MATERIALS: dict[str, dict[str, float]] = {
    # León 2001, finite-element chapter. Without fatigue data, so that half the ultimate strength is taken.
    "leon-2001": {
        "E_GPa": 207.0,
        "nu": 0.28,
        "density_kg_m3": 7700.0,
        "yield_MPa": 620.4,
        "ultimate_MPa": 723.8,
    },
    # Forged steel of a production connecting rod, specimens cut from rods: Shenoy & Fatemi, SAE 2005-01-0987.
    # Strength at 10⁶ cycles.
    "forged-steel-2005": {
        "E_GPa": 207.0,
        "nu": 0.30,
        "density_kg_m3": 7820.0,
        "yield_MPa": 700.0,
        "ultimate_MPa": 938.0,
        "endurance_MPa": 423.0,
    },
    # C-70, the steel of fracture-split rods, same source. Strength at 10⁶ cycles.
    "c70-2005": {
        "E_GPa": 212.0,
        "nu": 0.30,
        "density_kg_m3": 7700.0,
        "yield_MPa": 574.0,
        "ultimate_MPa": 966.0,
        "endurance_MPa": 339.0,
    },
    # Hard steel of the bending and torsion tests of Nishihara & Kawamoto 1945; fatigue limits as tabled by
    # Papadopoulos et al. 1997 (Int. J. Fatigue 19), elastic constants those of any steel.
    "hard-steel-1945": {
        "E_GPa": 206.0,
        "nu": 0.29,
        "density_kg_m3": 7850.0,
        "yield_MPa": 500.0,
        "ultimate_MPa": 680.0,
        "endurance_MPa": 313.9,
        "endurance_torsion_MPa": 196.2,
    },
    # Ti-6Al-4V, annealed bar: ASM, Materials Properties Handbook: Titanium Alloys (1994). At 10⁷ cycles.
    "ti-6al-4v": {
        "E_GPa": 113.8,
        "nu": 0.342,
        "density_kg_m3": 4430.0,
        "yield_MPa": 880.0,
        "ultimate_MPa": 950.0,
        "endurance_MPa": 510.0,
    },
    # 7075-T6: ASM Handbook, volume 2 (1990). At 5·10⁸ cycles, rotating bending.
    "al-7075-t6": {
        "E_GPa": 71.7,
        "nu": 0.33,
        "density_kg_m3": 2810.0,
        "yield_MPa": 503.0,
        "ultimate_MPa": 572.0,
        "endurance_MPa": 159.0,
    },
}
