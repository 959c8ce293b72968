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
    pedestal = find_effect("ambient_pedestal")
    settings = (pedestal.at(level=[1.0, 2.0]), find_effect("counter_saturation").at())
    alone = [p.name for p in pedestal.parameters if p.name != "level"]

    slopes = [
        ("ambient_pedestal", "level", 0, 5.0),
        ("ambient_pedestal", "level", 1, 7.0),
        *(("ambient_pedestal", name, None, 11.0 + k) for k, name in enumerate(alone)),
        ("counter_saturation", "lost", None, 3.0),
        ("counter_saturation", "ceiling", None, 2.0),
        ("counter_saturation", "slowing", None, 4.0),
        ("counter_saturation", "order", None, 6.0),
    ]

    def model(now):
        values = {setting.effect.id: setting.values for setting in now}
        return np.array([slope * np.atleast_1d(values[of][name])[zone or 0] for of, name, zone, slope in slopes])

    found = derivatives(model, settings)
    assert [(d.effect, d.parameter, d.zone) for d in found] == [one[:3] for one in slopes]
    assert np.stack([d.by_unit for d in found]) == pytest.approx(np.diag([one[3] for one in slopes]), abs=1e-6)
