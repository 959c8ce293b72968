"""What effects own up to: that they have looked at a recording, or that nobody saw what they would have to know."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True, eq=False)
class Look:
    """What an effect that looks at a recording, to see where things are in each frame, has to own up to.

    flattery: deviance by which its counts fit the frames better than the evidence of the frames allows. blur: deviance
    that is left because where things are stays uncertain. sloping: gives `slopes`, which take longer and are seldom
    asked for.
    """

    flattery: float
    blur: float
    sloping: Callable[[], dict[str, np.ndarray]]

    @cached_property
    def slopes(self) -> dict[str, np.ndarray]:
        """Of each parameter that says what is looked for, (F,) or, of each zone, (F, P): of the log-likelihood."""
        return self.sloping()


@dataclass(frozen=True, eq=False)
class Unseen:
    """What a model leaves uncertain. variance: (F, P, T) of counts, beyond that of photons. together: how many cells
    are off alike: sums of so many scatter that much more than those of cells which are each off by themselves. blind:
    (F,) frames that were taken when nobody saw the scene, so that they tell nothing; None where there are none.
    at_most: (F,) how many times the variance that of a single frame may be, where it is the mean of what seldom happens
    and is then large; None where frames are off as much as one another.
    """

    variance: np.ndarray
    together: float
    blind: np.ndarray | None = None
    at_most: np.ndarray | None = None
