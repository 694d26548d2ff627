"""Forces in a bolted joint under an axial load (VDI 2230-1:2015, section 3.2.1, steps R3 to R5).

Compliances in mm/N, forces in N, lengths in mm. A load that pulls the parts apart is positive.
"""


def load_factor(bolt: float, parts: float, introduction: float = 1.0) -> float:
    """Φ_n = n δ_P/(δ_S + δ_P): share of an axial load that the bolt carries (R3)."""
    return introduction * parts / (bolt + parts)


def bolt_force(preload: float, factor: float, load: float) -> float:
    """F_S = F_V + Φ F_A while the joint is closed, and F_A after it opened."""
    return load if load > opening_load(preload, factor) else preload + factor * load


def clamp_force(preload: float, factor: float, load: float) -> float:
    """F_K = F_V − (1 − Φ) F_A: force between the parts; 0 after the joint opened."""
    return max(preload - (1 - factor) * load, 0.0)


def opening_load(preload: float, factor: float) -> float:
    """F_A at which the joint of a central load opens: F_V/(1 − Φ)."""
    return preload / (1 - factor)


def embedding_loss(embedding: float, bolt: float, parts: float) -> float:
    """F_Z = f_Z/(δ_S + δ_P): preload that embedding by f_Z takes (R4/1)."""
    return embedding / (bolt + parts)


def thermal_slack(grip: float, bolt_expansion: float, parts_expansion: float, warming: float) -> float:
    """l_K (α_S − α_P) ΔT: by how much more a bolt expands than the parts; over δ_S + δ_P, ΔF_Vth (R4/2)."""
    return grip * (bolt_expansion - parts_expansion) * warming


# f_Z, µm, of thread, each seat of head or nut, each inner joint, by the roughness R_z up to µm (VDI 2230-1,
# table 5, for axial load; the shares under transverse load are larger).
_EMBEDDING = {10.0: (3.0, 2.5, 1.5), 40.0: (3.0, 3.0, 2.0), 160.0: (3.0, 4.0, 3.0)}


def expected_embedding(roughness: float = 40.0, *, seats: int = 2, joints: int = 1) -> float:
    """f_Z of table 5, mm, of parts with a roughness R_z of at most 160 µm, in steel."""
    thread, seat, joint = next(amounts for most, amounts in _EMBEDDING.items() if roughness <= most)
    return (thread + seats * seat + joints * joint) * 1e-3
