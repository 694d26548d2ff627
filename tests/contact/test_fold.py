"""What unknowns on both sides of y = 0 do, against the sums over their even and odd parts."""

import numpy as np
import pytest

from fea.contact.fold import Fold


@pytest.mark.parametrize("both_sides", [True, False])
@pytest.mark.parametrize("images", [2, 4])
def test_the_compliance_is_that_of_the_parts(both_sides, images):
    rng = np.random.default_rng(images)
    on_y, across = rng.random((2, 40)) < [[0.3], [0.5]]
    fold = Fold(on_y, both_sides, images, across)
    of_cell = {parity: rng.normal(size=(40, 40)) for parity in fold.parities()}
    parts = fold.parts(np.eye(fold.size))
    moments = fold.moments({parity: own @ parts[parity] for parity, own in of_cell.items()})
    np.testing.assert_array_equal(fold.compliance(of_cell), moments)
