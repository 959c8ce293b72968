"""Central differences of functions whose derivative is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from physics.effect import Parameter
from physics.effects import find_effect
from physics.sensitivity import derivatives, difference


@given(st.floats(0, 2))
def test_at_and_between_the_bounds(here):
    parameter = Parameter("x", "1", 0.0, 2.0, 1.0, "A number.")

    def at(x):
        assert 0 <= x <= 2
        return np.array([np.sin(3 * x), x**2])

    np.testing.assert_allclose(difference(at, here, parameter), [3 * np.cos(3 * here), 2 * here], atol=1e-4)


def test_one_for_every_parameter_and_zone():
    settings = (find_effect("ambient_pedestal").at(level=[1.0, 2.0]), find_effect("counter_saturation").at())

    def model(now):
        level, counter = now[0].values["level"], now[1].values
        growth, more = now[0].values["growth"], now[0].values["more"]
        return np.array(
            [level[0] * 5, level[1] * 7, growth * 11, more * 13, counter["lost"] * 3, counter["ceiling"] * 2]
        )

    found = derivatives(model, settings)
    assert [(d.effect, d.parameter, d.zone) for d in found] == [
        ("ambient_pedestal", "level", 0),
        ("ambient_pedestal", "level", 1),
        ("ambient_pedestal", "growth", None),
        ("ambient_pedestal", "more", None),
        ("counter_saturation", "lost", None),
        ("counter_saturation", "ceiling", None),
    ]
    assert np.stack([d.by_unit for d in found]) == pytest.approx(np.diag([5.0, 7, 11, 13, 3, 2]), abs=1e-6)
