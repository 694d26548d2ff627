"""Materials by name, in the units of a study file, each with its source.

The endurance limit is that of polished specimens under fully reversed stress; for a metal whose S-N curve has
no knee, it holds at the number of cycles given. σ_f′ and b are of the S-N line σ_a = σ_f′ (2N)^b of such
specimens; a material without them has no published line that fits its other figures. All are published
figures of one heat or typical values: a design needs figures of its own material.
"""

MATERIALS: dict[str, dict[str, float]] = {
    "leon-2001": {
        "E_GPa": 207.0,
        "nu": 0.28,
        "density_kg_m3": 7700.0,
        "yield_MPa": 620.4,
        "ultimate_MPa": 723.8,
    },
    "forged-steel-2005": {
        "E_GPa": 207.0,
        "nu": 0.30,
        "density_kg_m3": 7820.0,
        "yield_MPa": 700.0,
        "ultimate_MPa": 938.0,
        "endurance_MPa": 423.0,
        "fatigue_strength_coefficient_MPa": 1188.0,
        "fatigue_strength_exponent": -0.0711,
    },
    "c70-2005": {
        "E_GPa": 212.0,
        "nu": 0.30,
        "density_kg_m3": 7700.0,
        "yield_MPa": 574.0,
        "ultimate_MPa": 966.0,
        "endurance_MPa": 339.0,
        "fatigue_strength_coefficient_MPa": 1303.0,
        "fatigue_strength_exponent": -0.0928,
    },
    "hard-steel-1945": {
        "E_GPa": 206.0,
        "nu": 0.29,
        "density_kg_m3": 7850.0,
        "yield_MPa": 500.0,
        "ultimate_MPa": 680.0,
        "endurance_MPa": 313.9,
        "endurance_torsion_MPa": 196.2,
    },
    "ti-6al-4v": {
        "E_GPa": 113.8,
        "nu": 0.342,
        "density_kg_m3": 4430.0,
        "yield_MPa": 880.0,
        "ultimate_MPa": 950.0,
        "endurance_MPa": 510.0,
    },
    "al-7075-t6": {
        "E_GPa": 71.7,
        "nu": 0.33,
        "density_kg_m3": 2810.0,
        "yield_MPa": 503.0,
        "ultimate_MPa": 572.0,
        "endurance_MPa": 159.0,
    },
    "cusn8p": {
        "E_GPa": 115.0,
        "nu": 0.34,
        "density_kg_m3": 8800.0,
        "yield_MPa": 280.0,
        "ultimate_MPa": 460.0,
    },
    "steel-backed-shell": {
        "E_GPa": 179.0,
        "nu": 0.30,
        "density_kg_m3": 6900.0,
        "yield_MPa": 280.0,
    },
    "bolt-8.8": {
        "E_GPa": 205.0,
        "nu": 0.30,
        "density_kg_m3": 7850.0,
        "yield_MPa": 640.0,
        "ultimate_MPa": 800.0,
    },
    "bolt-9.8": {
        "E_GPa": 205.0,
        "nu": 0.30,
        "density_kg_m3": 7850.0,
        "yield_MPa": 720.0,
        "ultimate_MPa": 900.0,
    },
    "bolt-10.9": {
        "E_GPa": 205.0,
        "nu": 0.30,
        "density_kg_m3": 7850.0,
        "yield_MPa": 940.0,
        "ultimate_MPa": 1040.0,
    },
    "bolt-12.9": {
        "E_GPa": 205.0,
        "nu": 0.30,
        "density_kg_m3": 7850.0,
        "yield_MPa": 1100.0,
        "ultimate_MPa": 1220.0,
    },
}

_ISO_898 = (
    "Bolt of property class {}, least strengths of ISO 898-1:2013, table 3{}; elastic constants typical of "
    "steel. The endurance of threads is that of VDI 2230, not of this table."
)

# Sources of the figures, and how far they were checked.
SOURCES: dict[str, str] = {
    "leon-2001": (
        "León 2001, finite-element chapter. It gives no endurance limit: half the ultimate strength is used."
    ),
    "forged-steel-2005": (
        "Forged steel of a production connecting rod, Shenoy & Fatemi, SAE 2005-01-0987; endurance limit at "
        "10⁶ cycles, S-N line of specimens cut from rods. The figures could not be checked against the "
        "paper, but limit and line agree: σ_f′ (2·10⁶)^b = 423 MPa. Check them before you rely on them."
    ),
    "c70-2005": (
        "C-70, the steel of fracture-split rods, from the same paper; endurance limit at 10⁶ cycles and S-N "
        "line. These figures could not be checked either; limit and line agree: σ_f′ (2·10⁶)^b = 339 MPa."
    ),
    "hard-steel-1945": (
        "Hard steel of Nishihara & Kawamoto 1945, limits in bending and torsion as tabulated by Papadopoulos "
        "et al. 1997 (Int. J. Fatigue 19, 219). Their ratio, 0.625, is confirmed by Tveit et al. 2026 "
        "(Procedia Structural Integrity 82, 112); the limits themselves and the static strengths could not "
        "be checked. The elastic constants are typical of steel."
    ),
    "ti-6al-4v": (
        "Ti-6Al-4V, grade 5, annealed: data sheet MTP641 of ASM and MatWeb; endurance limit of smooth "
        "specimens at 10⁷ cycles, from sheet MTP644 of annealed bar. The sheet does not state the stress "
        "ratio; fully reversed is assumed. Sintered grades have 300…600 MPa (Sci. Rep. 7, 41444, table 1)."
    ),
    "al-7075-t6": (
        "7075-T6, typical values of the Aluminum Association on the data sheet of ASM and MatWeb, marked "
        "'not for design'; endurance limit from the R. R. Moore rotating-beam test, fully reversed, usually "
        "at 5·10⁸ cycles. The strengths are confirmed by two suppliers' tables (572, 503 and 158…159 MPa); "
        "one of them gives 71.0 GPa instead of 71.7."
    ),
    "cusn8p": (
        "Bearing bronze CuSn8P (CW459K), tubes of temper R460: least strengths of EN 12449 and Young's "
        "modulus on a supplier's data sheet (Caro Bronze); ν and density of C52100. No endurance is known."
    ),
    "steel-backed-shell": (
        "Bearing shell of 1.2 mm of steel (206 GPa, 7850 kg/m³) and 0.3 mm of AlSn20Cu (71 GPa, 3100 kg/m³): "
        "mean stiffness and density. The yield strength is an estimate for a backing of cold-worked "
        "low-carbon steel: give that of your shell."
    ),
    "bolt-8.8": _ISO_898.format("8.8", ", up to M16"),
    "bolt-9.8": _ISO_898.format("9.8", ""),
    "bolt-10.9": _ISO_898.format("10.9", ""),
    "bolt-12.9": _ISO_898.format("12.9", ""),
}
