"""Everything between a scene and its expected counts: what each step of the model made, for the steps after it."""

from dataclasses import dataclass

import numpy as np

from physics.arrivals import Arrivals
from physics.clock import Clock
from physics.footprint import Footprints
from physics.light import Light

# In the order in which they come to be.
NOUNS = ("light", "footprints", "clock", "arrivals", "background", "expected")


@dataclass(frozen=True, eq=False)
class Rendering:
    """F frames on their way through the model; what comes later is None until it is made.

    light: what the scene sends back. footprints: where zones look. clock: how time is registered.
    arrivals: light by zone and time of arrival, before pulse and bins. gain: counts per unit of light.
    background: (P, 1) or (F, P, 1) counts per bin that no laser sent, or one number. expected: (F, P, T) counts,
    background included. recorded: (F, P, T) counts that were recorded, None where nothing was: for effects that only a
    frame itself can place.
    """

    light: Light
    footprints: Footprints
    clock: Clock
    gain: float
    arrivals: Arrivals | None = None
    expected: np.ndarray | None = None
    background: np.ndarray | float = 0.0
    recorded: np.ndarray | None = None
