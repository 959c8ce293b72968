"""A pedestal in closed form: as many counts in every bin, and more of them with time."""

import numpy as np

from physics.effects.ambient_pedestal import effect
from physics.nominal import ForwardModel


def test_every_bin_has_as_many_more(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 3.0)
    more = model.expected(50.0, [effect.at(level=[1, 2, 3, 4.5])]) - model.expected(50.0)
    np.testing.assert_allclose(more, np.broadcast_to(np.array([1, 2, 3, 4.5])[:, None], more.shape))


def test_it_grows_with_time_in_all_zones_alike(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 3.0)
    more = model.expected(50.0, [effect.at(level=[1, 2, 3, 4.5], growth=30)]) - model.expected(50.0)
    for i, grown in enumerate((0, 3, 6)):
        np.testing.assert_allclose(more[i], np.broadcast_to(np.array([1, 2, 3, 4.5])[:, None] + grown, more[i].shape))


def test_it_shrinks_to_none_but_not_below(small):
    model = ForwardModel(small.light, small.footprints, small.clock, [3.0, 0, 1, 9])
    signal = ForwardModel(small.light, small.footprints, small.clock).expected(50.0)
    rest = model.expected(50.0, [effect.at(level=1, growth=-30)]) - signal
    np.testing.assert_allclose(rest[..., 0], [[4, 1, 2, 10], [1, 0, 0, 7], [0, 0, 0, 4]], atol=1e-9)


def test_the_same_light_may_be_brighter_than_it_was(small):
    recorded = np.array([3.0, 0, 1, 9])
    model = ForwardModel(small.light, small.footprints, small.clock, recorded)
    more = model.expected(50.0, [effect.at(more=0.4)]) - model.expected(50.0)
    np.testing.assert_allclose(more, np.broadcast_to(0.4 * recorded[:, None], more.shape), atol=1e-9)
