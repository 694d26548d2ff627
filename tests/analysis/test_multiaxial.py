"""The least factor by Crossland over the whole rod."""

import numpy as np
import pytest
from cycles import analysis

from fea.analysis.cycle import envelope as envelopes
from fea.analysis.pipeline import prepare, solve_speed, with_cycle
from fea.base.choices import Symmetry
from fea.judge.fatigue import crossland_factors
from fea.judge.history import deviatoric
from fea.study.flags import Flags
from fea.study.study import load_study

pytestmark = pytest.mark.slow


def test_no_node_of_the_rod_is_worse(monkeypatch):
    rod = analysis(Symmetry.QUARTER, 14.0)
    looked = []
    known = envelopes.spots
    monkeypatch.setattr(envelopes, "spots", lambda nodes, *rest: looked.extend(nodes) or known(nodes, *rest))
    found = with_cycle(rod, solve_speed(rod, 6000.0)).cycle
    cycle = rod.cycle
    weights = cycle.weights(rod.crank_cycle(6000), found.angles)
    tensors = cycle.units.tensor(0, weights, rod.mesh.mirrored)
    (material,), worst = rod.materials, found.multiaxial
    surface = found.regions.factors(material)
    factors = crossland_factors(deviatoric(tensors), material, surface)
    best = crossland_factors(deviatoric(worst.stress[None]), material, surface[factors.argmin()])[0]
    assert best == pytest.approx(factors.min(), rel=1e-3)
    assert 0 < len(looked) < 0.05 * len(factors)  # by its bound alone the rest is known to be better
    np.testing.assert_allclose(rod.mesh.whole.points[factors.argmin()][:2], worst.place[:2], atol=14.0)
    # The array is the least factor where that is, and elsewhere on the safe side of the factor, if little.
    array = found.envelope.point_data()["crossland_safety_factor"]
    assert array.min() == pytest.approx(best, rel=1e-6)
    short = array / factors
    assert short.max() < 1 + 1e-3
    assert np.median(short) > 0.9
    assert np.percentile(short, 5) > 0.8


BUSHED = """
[rod]
preset = "leon-2001"
shank_section = "rectangular"
bushing_mm = 2.0
[material]
preset = "leon-2001"
[material.bushing]
E_GPa = 110.0
nu = 0.34
density_kg_m3 = 8800
yield_MPa = 4000.0
ultimate_MPa = 4000.0
endurance_MPa = {endurance}
[engine]
stroke_mm = 94.0
bore_mm = 76.0
piston_mass_kg = 1.3345
gas = "leon-2001"
[analysis]
pressure = "cosine-180"
"""


@pytest.mark.parametrize("endurance", [1.0, 4000.0])
def test_where_parts_meet_the_lesser_factor_counts_though_the_other_part_is_nearer_to_yielding(
    tmp_path, endurance
):
    (tmp_path / "bushed.toml").write_text(BUSHED.format(endurance=endurance))
    flags = Flags(size=20.0, cycle=True, unusual=True)
    rod = prepare(flags.applied(load_study(str(tmp_path / "bushed.toml"))))
    found, whole = with_cycle(rod, solve_speed(rod, 6000.0)).cycle, rod.mesh.mirrored
    cycle = rod.cycle
    weights = cycle.weights(rod.crank_cycle(6000), found.angles)
    at_once = (cycle.units.tensor(number, weights.at(slice(1)), whole) for number in (0, 1))
    shared = ~np.isnan([tensor[:, 0, 0] for tensor in at_once]).any(axis=0)
    least = np.inf
    for number, material in enumerate(rod.materials):
        tensor = cycle.units.tensor(number, weights, whole)[shared]
        least = np.minimum(least, crossland_factors(deviatoric(tensor), material))
    assert (found.envelope.part[shared] == 0).any()  # by yielding alone the bushing would not be looked at
    worst, _ = envelopes.worst_multiaxial(
        found.envelope, cycle.units, weights, whole, rod.materials, counts=shared, regions=found.regions
    )
    (best,) = crossland_factors(deviatoric(worst.stress[None]), rod.materials[worst.part])
    assert best == pytest.approx(least.min(), rel=1e-3)
    assert (found.envelope.crossland_factor[shared] <= least * (1 + 1e-3)).all()
