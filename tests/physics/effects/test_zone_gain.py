import numpy as np

from physics.effects.cover_glass_crosstalk import effect as crosstalk
from physics.effects.zone_gain import effect
from physics.nominal import ForwardModel

FACTORS = np.array([0, 0.5, 1, 3])


def test_each_zone_is_multiplied_and_its_background_is_not(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 7.0)
    signal = model.expected(50.0) - 7
    np.testing.assert_allclose(
        model.expected(50.0, [effect.at(factor=FACTORS)]) - 7, signal * FACTORS[:, None], atol=1e-10
    )


def test_crosstalk_is_multiplied_too(small):
    model = ForwardModel(small.light, small.footprints, small.clock)
    both = model.expected(50.0, [effect.at(factor=FACTORS), crosstalk.at()])
    np.testing.assert_allclose(both, model.expected(50.0, [crosstalk.at()]) * FACTORS[:, None], atol=1e-10)
