"""What forms are asked beside, a fit of a recording; and the same of some of its frames, which cost less."""

from functools import cached_property

import numpy as np

from mismatch.fit import Fit, begin_beside
from mismatch.projection import Projection
from mismatch.simulation import Simulation

# One of so many frames is taken evenly, and one of so many of those that fit worst, as some causes show in few.
EVENLY, WORST = 6, 12
# As many at least, of each kind; of fewer frames than twice all those none is left out.
FEWEST_EVENLY, FEWEST_WORST = 6, 2
# Nor where all take so little time that some would take as much: pixels and cells.
LARGE = 200_000
# Standard deviations of noise beyond which a frame fits badly.
BADLY = 3.0
# Multiples of this fall evenly between whole numbers and go along with no period of a scene (Weyl 1916).
GOLDEN = (5**0.5 - 1) / 2


class Beside:
    """A simulation, what is fitted to it, and the projection that takes out what the fit can make."""

    def __init__(self, simulation: Simulation, fitted: Fit) -> None:
        self.simulation, self.fitted = simulation, fitted
        begin_beside(simulation, fitted)
        self.projection = Projection(simulation, fitted)  # At once: threads share it.

    @property
    def frames(self) -> int:
        """How many there are."""
        return len(self.simulation.counts)

    @cached_property
    def misfit(self) -> np.ndarray:
        """(F,) sum of squares of what is left, beyond what noise leaves."""
        left = self.projection.left.reshape(self.frames, -1)
        return (left**2).sum(axis=1) - left.shape[1]

    @cached_property
    def some(self) -> "Beside | None":
        """The same fit of some of the frames, those that fit worst among them; None where none is to be left out."""
        many, worst = (
            max(self.frames // one, least) for one, least in ((EVENLY, FEWEST_EVENLY), (WORST, FEWEST_WORST))
        )
        if self.frames < 2 * (many + worst) or self.simulation.numbers < LARGE:
            return None
        even = np.argsort(np.arange(self.frames) * GOLDEN % 1, kind="stable")[:many]
        bad = np.flatnonzero(self.misfit > BADLY * np.sqrt(2 * self.projection.left.size / self.frames))
        worst_first = bad[np.argsort(-self.misfit[bad], kind="stable")]
        fitted = self.fitted.of(self.simulation.remembered.frames(even, worst_first[:worst]))
        return Beside(fitted.simulation, fitted)
