"""The least factor by Crossland over the whole rod."""

import numpy as np
import pytest
from cycles import analysis

from fea.assess.crossland import crossland, crossland_factors
from fea.assess.deviatoric import deviatoric
from fea.choices import Symmetry
from fea.cycle import multiaxial
from fea.units import RPM


def test_no_node_of_the_rod_is_worse(monkeypatch):
    rod = analysis(Symmetry.QUARTER, 14.0)
    looked = []
    known = multiaxial.spots
    monkeypatch.setattr(multiaxial, "spots", lambda nodes, *rest: looked.extend(nodes) or known(nodes, *rest))
    found = rod.at(6000.0).cycle
    cycle = rod.cycle_analysis
    weights = cycle.weights(rod.engine, rod.gas, 6000 * RPM, found.angles)
    tensors = cycle.units.tensor(0, weights, rod.mesh.whole)
    factors = crossland_factors(deviatoric(tensors), rod.materials[0])
    best = crossland(deviatoric(found.multiaxial.stress), rod.materials[0])
    assert best == pytest.approx(factors.min(), rel=1e-3)
    assert 0 < len(looked) < 0.05 * len(factors)  # by its bound alone the rest is known to be better
    np.testing.assert_allclose(
        rod.mesh.whole.mesh.points[factors.argmin()][:2], found.multiaxial.place[:2], atol=14.0
    )
    # The array is the least factor where that is, and elsewhere on the safe side of the factor, if little.
    array = found.envelope.point_data()["crossland_safety_factor"]
    assert array.min() == pytest.approx(best, rel=1e-6)
    short = array / factors
    assert short.max() < 1 + 1e-3
    assert np.median(short) > 0.9
    assert np.percentile(short, 5) > 0.8
