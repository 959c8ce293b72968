"""One thing is wax, foam or skin: light enters it and comes out later."""

from dataclasses import replace

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.light import Light, Return
from physics.rendering import Rendering
from physics.told_apart import WHICH, numbers, surfaces_alone

# Surfaces that a fit tries, and delays that stand for an exponential: means of parts that are equally likely.
ALONE, PARTS = 6, 6


def delays() -> np.ndarray:
    """(PARTS,) means of an exponential of mean 1 in parts of equal probability."""
    ends = -np.log1p(-np.arange(PARTS) / PARTS)
    # The integral of t exp(-t) from a on is (1 + a) exp(-a).
    beyond = np.append((1 + ends) * np.exp(-ends), 0.0)
    return -np.diff(beyond) * PARTS


class Translucent(Effect):
    """Of what surface number `surface` returns the part `inside` comes later, by an exponential of mean `deep`.

    If every surface did so, or the only one, it would be a tail of the pulse.
    """

    id = "translucent"
    acts_on = "scene"
    order = 2
    sentence = "one surface lets light in, which comes out of it later"
    forms = (("inside", "deep"),)
    parameters = (
        Parameter("inside", "1", 0.0, 1.0, 0.1, "Part of its light that enters.", vanishes_at=0.0),
        Parameter("deep", "m", 0.005, 1.0, 0.06, "Half of the way it makes in there on average.", tries=(0.03, 0.1)),
        *WHICH,
    )

    def light(self, values: Values, rendering: Rendering) -> Light:
        """The scene with light that comes out late."""
        light = rendering.light
        if not values["inside"]:
            return light
        which = numbers(values, light)
        if which.max(initial=0) < 2:
            return light
        direct, *others = light.returns
        there = which == round(values["surface"])
        entered = np.where(there, direct.strength * np.float32(values["inside"]), np.float32(0))
        outside = replace(direct, strength=direct.strength - entered)
        late = (Return(direct.range_m + np.float32(values["deep"] * t), entered / PARTS) for t in delays())
        return replace(light, returns=(outside, *others, *late))

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Each of the largest surfaces, where there are several."""
        alone = surfaces_alone(rendering.light, ALONE)
        first, tries = {"inside": self.parameter("inside").start}, self.parameter("deep").tries
        return [first | which | {"deep": deep} for which in alone for deep in tries] if len(alone) > 1 else []


effect = Translucent()
