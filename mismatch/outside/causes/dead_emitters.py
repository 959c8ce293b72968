"""A row or column of the emitters goes dark."""

from dataclasses import replace

import numpy as np

from mismatch.outside.spot import places
from physics.effect import Effect, Parameter, Values
from physics.light import Light, Return
from physics.rendering import Rendering

# What no quotient may meet.
NOTHING = 1e-9


class DeadEmitters(Effect):
    """Less light in a stripe of the view, by the part `dark` at its middle, from the time `begins` of the session on.

    An array of emitters lights the field through a diffuser that blurs each row of them into a stripe. What a zone
    loses goes by how much of the stripe it sees, whatever is there, and all at once.
    """

    id = "dead_emitters"
    acts_on = "scene"
    sentence = "a stripe across the view is darker from some moment on, as where a row of emitters has died"
    forms = (("dark", "at", "wide"),)
    parameters = (
        Parameter("dark", "1", -3.0, 1.0, 0.2, "Part of the light that is gone at its middle.", 0.0),
        Parameter("at", "1", -0.5, 1.5, 0.5, "Where its middle is, as a part of the image's width, or height."),
        Parameter("wide", "1", 0.01, 1.0, 0.1, "Its standard deviation, likewise."),
        Parameter("lies", "1", 0.0, 1.0, 0.0, "1 where it lies along rows, 0 along columns.", tries=(1.0,)),
        Parameter("begins", "1", 0.0, 1.0, 0.0, "When it goes dark, as a part of the session."),
    )

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Where zones lose most, of what they had before the moment that parts frames best, along rows and columns."""
        if len(excess) < 2:
            return []  # One frame has no before.
        background = np.minimum(rendering.background, expected)
        light = np.maximum((expected - background).sum(axis=-1), NOTHING)
        part = excess.sum(axis=-1) / light
        first = _parted(part, light)
        before = (part[:first] * light[:first]).sum(axis=0) / light[:first].sum(axis=0)
        lost = before - (part[first:] * light[first:]).sum(axis=0) / light[first:].sum(axis=0)
        weights = rendering.footprints.weights
        weights = weights.mean(axis=0) if weights.ndim == 4 else weights
        seen = np.maximum(lost, 0) @ weights.reshape(len(weights), -1)
        if seen.sum() <= 0:
            return []
        begins = float(self._session(rendering.light)[first - 1 : first + 1].mean())
        middles = [float(seen @ where.ravel() / seen.sum()) for where in places(weights.shape[1:])]
        return [{"lies": float(lies), "at": at, "begins": begins} for lies, at in enumerate(middles)]

    def light(self, values: Values, rendering: Rendering) -> Light:
        """The scene as it is lit."""
        light = rendering.light
        where = places(light.rays.shape[:2])[int(values["lies"] > 0.5)]
        stripe = np.exp(-0.5 * ((where - values["at"]) / values["wide"]) ** 2)
        dead = self._session(light) >= values["begins"]
        left = (1 - values["dark"] * dead[:, None, None] * stripe).astype(np.float32)
        return replace(light, returns=tuple(Return(way.range_m, way.strength * left) for way in light.returns))

    @staticmethod
    def _session(light: Light) -> np.ndarray:
        """(F,) the frames' times as parts of the session."""
        every = light if light.part_of is None else light.part_of[0]
        return np.asarray(light.time_s) / max(float(np.max(every.time_s)), NOTHING)


def _parted(part: np.ndarray, light: np.ndarray) -> int:
    """The frame from which on what zones gain or lose differs most from before. part, light: (F, P)."""
    whole, weight = np.cumsum(part * light, axis=0), np.cumsum(light, axis=0)
    after, later = whole[-1] - whole[:-1], weight[-1] - weight[:-1]
    apart = (whole[:-1] / weight[:-1] - after / later) ** 2 * weight[:-1] * later / weight[-1]
    return 1 + int(apart.sum(axis=1).argmax())


effect = DeadEmitters()
