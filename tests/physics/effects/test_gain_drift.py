import numpy as np
import pytest

from physics.effects.gain_drift import effect
from physics.nominal import ForwardModel


@pytest.mark.parametrize("rate", [-0.7, 0.3])
def test_a_relaxation_of_first_order(small, rate):
    """Against many small steps of dN = rate · N · dt."""
    model = ForwardModel(small.light, small.footprints, small.clock, 3.0)
    ratio = model.expected(50.0, [effect.at(rate=rate)]) / model.expected(50.0)
    steps = 100_000
    euler = [(1 + rate * t / steps) ** steps for t in (0.0, 0.1, 0.2)]
    np.testing.assert_allclose(ratio, np.broadcast_to(np.reshape(euler, (3, 1, 1)), ratio.shape), rtol=1e-6)


def test_the_first_frame_stays(small):
    model = ForwardModel(small.light, small.footprints, small.clock, 3.0)
    np.testing.assert_array_equal(model.expected(9.0, [effect.at(rate=5)])[0], model.expected(9.0)[0])
