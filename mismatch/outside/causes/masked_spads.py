"""Some of a zone's detectors are switched off."""

import numpy as np

from mismatch.outside.spot import places, spot
from physics.effect import Effect, Parameter, Values
from physics.footprint import Footprints
from physics.rendering import Rendering


class MaskedSpads(Effect):
    """A zone's footprint has a bell-shaped hole, in which the part `depth` of its weight is gone.

    Firmware switches off single-photon detectors that are noisy; each watches a part of what its zone does.
    """

    id = "masked_spads"
    acts_on = "optics"
    sentence = "some detectors of a zone are switched off, a hole in its footprint"
    forms = (("depth", "across", "down", "wide"),)
    parameters = (
        Parameter("depth", "1", 0.0, 1.0, 0.3, "Part of the weight that is gone at the hole's centre.", 0.0),
        Parameter("across", "1", -0.5, 1.5, 0.5, "Where the hole is, as a part of the image's width."),
        Parameter("down", "1", -0.5, 1.5, 0.5, "Where it is, as a part of the image's height."),
        Parameter("wide", "1", 0.005, 1.0, 0.05, "Its standard deviation, as a part of the image's width."),
        Parameter("zone", "1", 0.0, 1e3, 0.0, "Which zone's."),
    )

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """In the zone that fits worst: at its middle, and a standard deviation from there on all sides."""
        chi = (excess**2 / np.maximum(expected, 1)).mean(axis=(0, 2))
        zone = int(np.argmax(np.where(expected.sum(axis=(0, 2)) > 0, chi, -1)))
        weights = rendering.footprints.weights
        weights = (weights.mean(axis=0) if weights.ndim == 4 else weights)[zone].astype(float)
        if not weights.sum() > 0:
            return []
        right, below = places(weights.shape)
        x, y = ((weights * at).sum() / weights.sum() for at in (right, below))
        far_x, far_y = (
            float(np.sqrt((weights * (at - mean) ** 2).sum() / weights.sum())) for at, mean in ((right, x), (below, y))
        )
        sides = ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1))
        wide = float(np.clip(0.7 * far_x, 0.005, 1.0))
        return [{"zone": zone, "wide": wide, "across": x + far_x * i, "down": y + far_y * j} for i, j in sides]

    def footprints(self, values: Values, rendering: Rendering) -> Footprints:
        """Footprints with the hole."""
        if not values["depth"]:
            return rendering.footprints

        def hole(weights: np.ndarray) -> np.ndarray:
            out = weights.copy()
            there = spot(weights.shape[-2:], values["across"], values["down"], values["wide"])
            out[..., int(values["zone"]), :, :] *= 1 - values["depth"] * there
            return out

        return rendering.footprints.changed(hole)


effect = MaskedSpads()
