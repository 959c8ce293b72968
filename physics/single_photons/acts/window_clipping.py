"""`window_clipping`: counts outside a window are thrown away."""

import numpy as np

from physics.effect import Values
from physics.single_photons.world import World


def counted(counts: np.ndarray, world: World, values: Values, rng: np.random.Generator) -> np.ndarray:
    """A count stands for a photon somewhere in its bin, and is kept where that is in the window."""
    bins = np.arange(world.bins)
    opens = np.clip(values["early"] - bins, 0, 1)
    closes = np.clip(world.bins - values["late"] - bins, 0, 1)
    return rng.binomial(counts, np.maximum(closes - opens, 0))
