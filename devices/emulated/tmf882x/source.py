"""What an emulated sensor sees while nobody says what is before it: a wall, in the light of a room."""

from collections.abc import Callable

import numpy as np

from devices.emulated.tmf882x.setting import Setting
from physics.timing import BIN_WIDTH_S, BINS, ZERO_BINS

# What is seen in a setting, (sets, 10, 128) counts below 2^24, channel 0 the reference; asked when a measurement ends.
Source = Callable[[Setting], np.ndarray]
REFERENCE_ZERO = {"long": 15.790, "short": 15.820}
SHOTS_PER_COUNT = 1000  # in the peak of a pulse
AMBIENT_SHOTS_PER_COUNT = 100_000
WIDTH_BINS = 1.3


class Wall:
    """A wall, range metres away from every zone; counts are Poisson."""

    def __init__(self, rng: np.random.Generator, range_m: float = 0.8) -> None:
        self._rng, self._range_m = rng, range_m

    def __call__(self, setting: Setting) -> np.ndarray:
        """(sets, 10, 128) counts."""
        delay_bins = 2 * self._range_m / 299_792_458.0 / BIN_WIDTH_S[setting.ranging]
        zero = np.array(ZERO_BINS[setting.ranging])
        centre = np.concatenate([[REFERENCE_ZERO[setting.ranging]], zero + delay_bins])
        shots = setting.kilo_iterations * 1024
        pulse = np.exp(-0.5 * ((np.arange(BINS) - centre[:, None]) / WIDTH_BINS) ** 2)
        expected = shots / SHOTS_PER_COUNT * pulse + shots / AMBIENT_SHOTS_PER_COUNT
        return self._rng.poisson(expected, (setting.sets, *expected.shape)).astype(np.uint32)
