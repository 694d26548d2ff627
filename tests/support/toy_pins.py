"""A pin model of a few lines, as one might add it: see `tests/pins/test_registry.py`."""

import numpy as np

from fea.pins.prescribed import LinearPins
from fea.solid.bore import BoreLoad
from fea.solid.parity import ParityPair


class EvenPins(LinearPins):
    """The same traction everywhere on a bore."""

    def load(self, bore, force):
        """Load a bore with a force (x, y) on the whole rod, N."""
        facets, share, touched = bore.facets, np.zeros(self.n_nodes), np.zeros(self.n_nodes)
        np.add.at(share, facets.nodes, facets.areas @ facets.shape_values)
        area = share.sum() * (2 if facets.cut_y else 1) * (2 if facets.cut_z else 1)
        touched[facets.nodes] = 1.0

        def split(shape):
            along, across = (
                np.outer(shape, vector) / area for vector in ([force[0], 0, 0], [0, force[1], 0])
            )
            return ParityPair(along, across) if facets.cut_y else ParityPair(along + across, None)

        return BoreLoad(split(share), split(touched), 1.0)
