import numpy as np

from physics.effects.ambient_pedestal import effect
from physics.nominal import ForwardModel


def test_every_bin_has_as_many_more(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 3.0)
    more = model.expected(50.0, [effect.at(level=[1, 2, 3, 4.5])]) - model.expected(50.0)
    np.testing.assert_allclose(more, np.broadcast_to(np.array([1, 2, 3, 4.5])[:, None], more.shape))
