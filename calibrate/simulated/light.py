"""Expected histograms of a scan: patch, scene, crosstalk and ambient light, in counts per frame."""

import numpy as np

from calibrate.simulated.bench import Bench
from calibrate.simulated.disc import from_discs, from_points
from calibrate.simulated.scene import Scene
from physics.optics import Optics
from physics.pulse import arrival
from physics.radiometry import SHEETING_PER_SR, returned
from physics.timing import Timing
from recordings.refusal import Refusal

# The strength of a scan is stated for this patch, so that another range or patch is as bright as it should
# be.
REFERENCE_RANGE_M, REFERENCE_RADIUS_M = 0.6, 0.0174
REFERENCE_SPADS = 20
# The window holds the bins in which a pulse reaches IN_PULSE of its peak, for responses of IN_MAP of the
# largest.
IN_PULSE, IN_MAP = 0.02, 0.01


class Light:
    """What reaches the zones of one sensor on one bench, as `simulate_scan` describes its arguments."""

    def __init__(
        self,
        bench: Bench,
        optics: Optics,
        timing: Timing,
        signal: float,
        laser_cycles: int,
        ambient_per_ns: float,
    ) -> None:
        self._bench, self._optics, self._timing = bench, optics, timing
        reference = returned(1.0, SHEETING_PER_SR, np.pi * REFERENCE_RADIUS_M**2, REFERENCE_RANGE_M)
        self._gain = signal * timing.energy * laser_cycles / reference
        self._scene = Scene(optics, timing, bench)
        inside = timing.pulse.in_bins(timing.time_zero_s, timing.bins, timing.bin_width_s)
        self._crosstalk = laser_cycles * timing.crosstalk[:, None] * inside
        spads = optics.spads.masks.sum(axis=(1, 2))[:, None]
        per_bin = ambient_per_ns * 1e9 * timing.bin_width_s
        self._ambient = laser_cycles * per_bin * spads / REFERENCE_SPADS

    def points(self, positions_m: np.ndarray) -> np.ndarray:
        """(P, K) photons per frame from patches shrunk to points at (K, 3), their light unchanged."""
        area = np.pi * self._bench.patch_radius_m**2
        return self._gain * from_points(self._optics, self._bench, positions_m, area)

    def discs(self, positions_m: np.ndarray) -> np.ndarray:
        """(P, K) photons per frame from patches centred at (K, 3)."""
        return self._gain * from_discs(self._optics, self._bench, positions_m)

    def expected(self, positions_m: np.ndarray, patch: np.ndarray, energy: np.ndarray) -> np.ndarray:
        """(F, P, T) expected counts with the flange at (F, 3) and (F, P) photons of the patch.

        energy: (F,) the laser's, relative. The whole patch is taken to be as far as its centre: at 15 degrees
        off the axis its edges are 4.5 mm nearer and further, a third of the narrowest bin.
        """
        timing = self._timing
        pulses = timing.pulse.in_bins(self._arrivals(positions_m), timing.bins, timing.bin_width_s)
        laser = patch[:, :, None] * pulses + self._gain * self._scene.photons(positions_m) + self._crosstalk
        return energy[:, None, None] * laser + self._ambient

    def window(self, positions_m: np.ndarray, discs: np.ndarray) -> tuple[int, int]:
        """First and last bin, both included, that hold pulses of patches at (K, 3) with (P, K) photons."""
        bright = (discs >= IN_MAP * discs.max(axis=1, keepdims=True)).T
        arrivals = self._arrivals(positions_m)[bright]
        ends = np.array([arrivals.min(), arrivals.max()])
        pulses = self._timing.pulse.in_bins(ends, self._timing.bins, self._timing.bin_width_s)
        if not pulses.max(axis=1).all():
            raise Refusal(
                f"simulated scan: the patch at {self._bench.patch_range_m} m returns after the last of "
                f"{self._timing.bins} bins of {self._timing.mode} range, expected within them"
            )
        held = np.flatnonzero((pulses > IN_PULSE * pulses.max(axis=1, keepdims=True)).any(axis=0))
        return int(held[0]), int(held[-1])

    def _arrivals(self, positions_m: np.ndarray) -> np.ndarray:
        """(F, P) nominal arrivals of light from (F, 3), seconds from the start of bin 0."""
        range_m = np.linalg.norm(self._bench.to_lidar(positions_m), axis=-1)
        return arrival(range_m[:, None], self._timing.time_zero_s)
