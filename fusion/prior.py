"""What unmixing believes of a scene before it looks."""

from dataclasses import dataclass, fields

import numpy as np

from recordings.refusal import Refusal


@dataclass(frozen=True)
class Prior:
    """Beliefs about scene and sensor; how they were chosen, and what others give, is in docs/quality.md.

    colour: a difference of colour (CIE Lab, white 1) of this much is an edge. left: so much of smoothness is left over
    any edge, since a change of colour may be paint or light. mean_off: standard deviation of what a zone's mean is off,
    because reflectance is not known, as part of how much means vary. reach_px: over about so many pixels of the coarse
    grid one correction moves what is alike. rounds, steps: corrections, and how many before incidence is computed anew;
    few keep to the smoothest image, many to the histograms. certain: light counts where there is so many times its
    standard error. least_sigma, of_spread: standard deviation of the logarithm of range, at least, and as part of the
    spread of ranges in the zones.

    Where images of a moving camera tell range, too: smooth, mean_sigma: standard deviations, in the logarithm of range,
    of a step between pixels of the coarse grid on one surface, and of a zone's mean; agree: they are believed
    where what they make alone is so many times as far from the zones' histograms as what the means alone make.
    """

    colour: float = 0.05
    left: float = 0.01
    mean_off: float = 0.02
    reach_px: float = 14.0
    rounds: int = 3
    steps: int = 6
    smooth: float = 0.03
    mean_sigma: float = 0.02
    agree: float = 1.6
    certain: float = 10.0
    least_sigma: float = 0.05
    of_spread: float = 0.65

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (np.isfinite(value) and value >= 0) or (
                field.name in ("colour", "reach_px", "smooth") and value == 0
            ):
                raise Refusal(f"prior: {field.name} is {value}, expected a finite number above 0")

    @property
    def ridge(self) -> float:
        """What pulls a correction to 0: it reaches 1/√ridge pixels."""
        return self.reach_px**-2
