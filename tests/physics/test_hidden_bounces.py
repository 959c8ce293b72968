"""What a bounce owns up to, against what it adds to a whole model."""

import numpy as np
import pytest

from physics.effects.multipath import effect
from physics.nominal import ForwardModel
from physics.rendering import Rendering

GAIN = 2e3


@pytest.mark.parametrize(("between", "aimed", "rough"), [(3.0, 0.0, 0.0), (1.0, 1.0, 0.0), (2.0, 0.4, 0.7)])
def test_a_bounce_may_be_off_by_as_much_as_it_is(small, between, aimed, rough):
    model = ForwardModel(small.light, small.footprints, small.clock, 4.0)
    setting = effect.at(between=between, aimed=aimed, rough=rough)
    added = model.expected(GAIN, [setting]) - model.expected(GAIN)
    found = effect.unseen(setting.values, Rendering(small.light, small.footprints, small.clock, GAIN))
    np.testing.assert_allclose(found.variance, added**2, rtol=1e-5, atol=1e-9 * (added**2).max())
    assert (found.variance > 0).any()
    assert found.together >= 1


def test_only_what_goes_between_surfaces_is_uncertain():
    assert effect.owns_up(effect.at(between=1.0).values)
    assert not effect.owns_up(effect.at(sensor=1e-3).values)
    assert not effect.owns_up(effect.vanished().values)
