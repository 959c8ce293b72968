"""Dirt or a drop on the lens."""

import numpy as np

from mismatch.outside.spot import places, spot
from physics.effect import Effect, Parameter, Values
from physics.footprint import Footprints
from physics.rendering import Rendering


class LensDirt(Effect):
    """All zones receive less by the part `dark` at the middle of a bell-shaped spot that is fixed in the view.

    A surface that is darker than was thought moves through the view with the scene.
    """

    id = "lens_dirt"
    acts_on = "optics"
    sentence = "a spot in the view is darker, whatever surfaces pass there"
    forms = (("dark", "across", "down", "wide"),)
    parameters = (
        Parameter(
            "dark", "1", -3.0, 1.0, 0.3, "Part of the light that is gone at its middle; there is more below 0.", 0.0
        ),
        Parameter("across", "1", -0.5, 1.5, 0.5, "Where it is, as a part of the image's width."),
        Parameter("down", "1", -0.5, 1.5, 0.5, "Where it is, as a part of the image's height."),
        Parameter(
            "wide", "1", 0.01, 1.0, 0.1, "Its standard deviation, as a part of the image's width.", tries=(0.06, 0.15)
        ),
    )

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """Amid the zones that receive less than they should, and amid those that receive more."""
        weights = rendering.footprints.weights
        weights = weights.mean(axis=0) if weights.ndim == 4 else weights
        right, below = places(weights.shape[1:])
        light = np.maximum(expected - rendering.background, 0).sum(axis=(0, 2))
        part = excess.sum(axis=(0, 2)) / np.maximum(light, 1)
        part = part - np.median(part)
        found = []
        for sign in (-1, 1):
            seen = np.maximum(sign * part, 0) @ weights.reshape(len(weights), -1)
            if seen.sum() > 0:
                found += [
                    {
                        "across": float(seen @ right.ravel() / seen.sum()),
                        "down": float(seen @ below.ravel() / seen.sum()),
                    }
                    | {"wide": wide}
                    for wide in self.parameter("wide").tries
                ]
        return found

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """Footprints, darker in the spot."""
        if not values["dark"]:
            return rendering.footprints

        def darkened(weights: np.ndarray) -> np.ndarray:
            there = spot(weights.shape[-2:], values["across"], values["down"], values["wide"])
            return weights * (1 - values["dark"] * there).astype(weights.dtype)

        return rendering.footprints.changed(darkened)


effect = LensDirt()
