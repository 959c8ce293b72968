"""`counter_saturation`: a counter that is full stops."""

import numpy as np

from physics.effect import Values
from physics.single_photons.draw import by_zone
from physics.single_photons.world import World


def counted(counts: np.ndarray, world: World, values: Values, rng: np.random.Generator) -> np.ndarray:
    """Of the counts beyond the ceiling each is lost, with the probability `lost`; of all, some where it slows down."""
    shown = (1 + (values["slowing"] * counts) ** float(values["order"])) ** (-1 / values["order"])
    counts = rng.binomial(counts, shown)
    beyond = np.maximum(counts - by_zone(world, values["ceiling"]).astype(int)[:, None], 0)
    return counts - rng.binomial(beyond, values["lost"])
