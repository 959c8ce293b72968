"""The example of an effect from outside, as the documentation prints it."""

import re
from pathlib import Path

import numpy as np

from physics.effects import fault_of
from physics.nominal import ForwardModel

PAGE = Path(__file__).parents[3] / "docs" / "simulation.md"


def test_it_works_as_printed(small):
    (code,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    names = {}
    exec(code, names)
    effect = names["effect"]
    assert fault_of(effect, "dust_on_the_window") is None
    model = ForwardModel(small.light, small.footprints, small.clock)
    nominal, found = model.expected(100.0), model.expected(100.0, [effect.at(absorbed=[0, 0.1, 0.5, 1])])
    np.testing.assert_allclose(found, nominal * np.array([1, 0.81, 0.25, 0])[:, None], rtol=1e-6)
    np.testing.assert_array_equal(model.expected(100.0, [effect.vanished()]), nominal)
