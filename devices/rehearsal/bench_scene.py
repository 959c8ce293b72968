"""What sensor and camera would see of the arm with the patch, at any pose of the tool."""

from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from calibrate.plan import ScanPlan
from calibrate.rig import LidarSetup, Rig
from calibrate.simulated.bench import Bench
from calibrate.simulated.frames import FrameRenderer, Mishaps
from calibrate.simulated.light import Light
from devices.scan.motion_plan import MotionPlan
from physics.optics import Optics, tmf882x_optics
from physics.photons import draw_counts
from physics.timing import BINS, CALIBRATION_CYCLES, ENERGY, tmf882x_timing
from recordings.refusal import Refusal

# The SPAD maps of the modes that the simulated optics know.
SPAD_MAPS = {"3x3": 6, "4x4": 7, "3x6": 10}
# Where the camera stands in the arm's base frame: beyond the patch, looking back at it, upright.
CAMERA_AT_M = (1.30, 0.0, 0.45)
CAMERA_AXES = ((0, 0, -1.0), (1.0, 0, 0), (0, -1.0, 0))
TOOL_AXES = ((0, 0, 1.0), (0, 1.0, 0), (-1.0, 0, 0))
# Photons per shot from a 17.4 mm patch at 0.6 m, and ambient counts per shot and nanosecond, as in simulated scans.
SIGNAL, AMBIENT_PER_NS, GAIN_NOISE = 0.7, 1e-4, 0.003
# The reference channel's peak of one device's factory calibration, in bins and in counts for 4000 kilo-iterations.
REFERENCE_BIN, REFERENCE_COUNTS = 15.8, 577218


class BenchScene:
    """One bench, one sensor, and a patch that is on its holder or not.

    Positions are of the patch's centre in the camera's frame; `patch` may be set at any time.
    """

    def __init__(self, setup: LidarSetup, rng: np.random.Generator, bench: Bench | None = None) -> None:
        if setup.mode not in SPAD_MAPS:
            raise Refusal(f"lidar.mode is {setup.mode!r}, expected one of {', '.join(SPAD_MAPS)} to rehearse with")
        self.bench, self.patch = bench or Bench(jitter_m=0.0), True
        self.optics: Optics = tmf882x_optics(SPAD_MAPS[setup.mode], rng.spawn(1)[0])
        self.timing = tmf882x_timing(setup.ranging, len(self.optics.spads.masks))
        plates, self._counting, self._exposing = rng.spawn(3)
        self._renderer = FrameRenderer(self.bench, plates)
        self._light = cache(self._light_of)

    def position_m(self, tool_pose: np.ndarray) -> np.ndarray:
        """(3,) of the patch for a pose (6,) of the tool in the arm's base frame."""
        return (np.asarray(tool_pose)[:3] - CAMERA_AT_M) @ np.array(CAMERA_AXES)

    def counts(self, tool_pose: np.ndarray, kilo_iterations: int) -> np.ndarray:
        """(P + 1, T) counts of one measurement, the reference channel first."""
        cycles = 1024 * kilo_iterations
        at = self.position_m(tool_pose)[None]
        light = self._light(cycles)
        lit = light.discs(at).T * self.patch
        energy = np.maximum(1 + GAIN_NOISE * self._counting.standard_normal(1), 0)
        zones = draw_counts(light.expected(at, lit, energy), self._counting)[0]
        pulse = self.timing.pulse.in_bins(
            np.array([REFERENCE_BIN * self.timing.bin_width_s]), BINS, self.timing.bin_width_s
        )
        mean = REFERENCE_COUNTS * ENERGY[self.timing.mode] * cycles / CALIBRATION_CYCLES * energy * pulse[0]
        return np.vstack([self._counting.poisson(mean), zones]).astype(np.uint32)

    def picture(self, tool_pose: np.ndarray) -> np.ndarray:
        """(H, W, 3) uint8, what the camera sees."""
        mishaps = Mishaps() if self.patch else Mishaps(missing=frozenset([0]))
        return self._renderer.render(self.position_m(tool_pose), 0, self._exposing, mishaps)

    def truth(self, tool_poses: np.ndarray, kilo_iterations: int) -> np.ndarray:
        """(P, K) photons of the patch at poses (K, 6), all bins: what the maps should be, but for noise."""
        at = np.stack([self.position_m(pose) for pose in tool_poses])
        return self._light(1024 * kilo_iterations).discs(at)

    def plan(self, columns: int, rows: int, **more) -> MotionPlan:
        """A plan whose corners are those of the bench's grid."""
        corners = ScanPlan(2, 2, order="raster")
        at = self.bench.patch_positions(corners, np.random.default_rng(0))
        place = np.array(CAMERA_AXES) @ at.T
        turn = Rotation.from_matrix(np.array(TOOL_AXES)).as_rotvec()
        low_left, _, up_left, up_right = (tuple(float(x) for x in (*(p + CAMERA_AT_M), *turn)) for p in place.T)
        return MotionPlan(columns, rows, low_left, up_left, up_right, **more)

    def rig(self, lidar: LidarSetup, **more) -> Rig:
        """The rig of this bench."""
        bench = self.bench
        return Rig(
            name="rehearsal",
            lidar_position_m=bench.lidar_position_m,
            lidar_rotation_deg=bench.lidar_rotation_deg,
            patch_radius_m=bench.patch_radius_m,
            patch_distance_m=bench.patch_range_m,
            lidar=lidar,
            **more,
        )

    def _light_of(self, cycles: int) -> Light:
        return Light(self.bench, self.optics, self.timing, SIGNAL, cycles, AMBIENT_PER_NS)
