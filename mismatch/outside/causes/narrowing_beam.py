"""The laser's light fades toward the edges of the field as the session goes on."""

from dataclasses import replace

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.light import Light, Return
from physics.rendering import Rendering


class NarrowingBeam(Effect):
    """Light times exp(-(at_first + narrowed · s) · (tan²θ - stays)), θ from the camera's axis.

    A laser that warms up drifts out of the passband of the receiver's filter, which lies elsewhere at larger angles:
    where more passes in the middle less does at the edges. Maps may be of another time than the session's begin. Over
    a session of length T, s = (1 - exp(-t / (settles · T))) / (1 - exp(-1 / settles)), from 0 to 1.
    """

    id = "narrowing_beam"
    acts_on = "scene"
    sentence = "light fades with the angle to the axis, the more the longer the session lasts"
    forms = (("narrowed",), ("narrowed", "settles"), ("narrowed", "at_first", "stays"))
    parameters = (
        Parameter("narrowed", unit="1", low=-20.0, high=20.0, start=0.2, vanishes_at=0.0, sentence="At 45 degrees."),
        Parameter(
            "settles",
            "1",
            0.02,
            20.0,
            20.0,
            "Part of the session in which it settles; steady where long.",
            tries=(0.3, 20.0),
        ),
        Parameter("stays", "1", 0.0, 4.0, 0.0, "tan² of the angle at which light stays as it was.", tries=(0.1,)),
        Parameter("at_first", "1", -20.0, 20.0, 0.2, "As `narrowed`, when the session begins.", vanishes_at=0.0),
    )

    def light(self, values: Values, rendering: Rendering) -> Light:
        """The scene as it is lit."""
        light = rendering.light
        every = light if light.part_of is None else light.part_of[0]
        part = np.asarray(light.time_s) / max(float(np.max(every.time_s)), 1e-300)
        since = np.expm1(-part / values["settles"]) / np.expm1(-1 / values["settles"])
        square = (light.rays[..., :2] ** 2).sum(axis=-1)
        faded = values["at_first"] + values["narrowed"] * since
        left = np.exp(-faded[:, None, None] * (square - values["stays"])).astype(np.float32)
        return replace(light, returns=tuple(Return(way.range_m, way.strength * left) for way in light.returns))


effect = NarrowingBeam()
