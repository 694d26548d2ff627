"""What unknowns on both sides of y = 0 do, against the sums over their even and odd parts."""

import numpy as np
import pytest

from fea.solid.parity import MirrorUnfolding


@pytest.mark.parametrize("both_sides", [True, False])
@pytest.mark.parametrize("images", [2, 4])
def test_the_compliance_is_that_of_the_parts(both_sides, images):
    rng = np.random.default_rng(images)
    on_y, across = rng.random((2, 40)) < [[0.3], [0.5]]
    unfolding = MirrorUnfolding(on_y, both_sides, images, across)
    of_cell = {parity: rng.normal(size=(40, 40)) for parity in unfolding.parities()}
    parts = unfolding.parts(np.eye(unfolding.size))
    moments = unfolding.moments({parity: own @ parts[parity] for parity, own in of_cell.items()})
    np.testing.assert_array_equal(unfolding.compliance(of_cell), moments)
