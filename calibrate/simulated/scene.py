"""What the zones see beside the patch: cloth, arm and flange, each a matt plane parallel to the image."""

import numpy as np

from calibrate.simulated import arm
from calibrate.simulated.bench import Bench
from physics.optics import Optics
from physics.pulse import arrival
from physics.radiometry import matt, returned
from physics.timing import Timing

# Near-infrared reflectances: black polyester is a few per cent, anodised and painted metal about half.
CLOTH_REFLECTANCE, ARM_REFLECTANCE, FLANGE_REFLECTANCE = 0.06, 0.5, 0.35
CLOTH_BEHIND_M = 0.6
# The sensor's field is divided into cells of this many tangents, out to where the flood has ended.
CELL = 0.03
REACH_X, REACH_Y = 0.5, 0.65


class Scene:
    """Light of the scene at any position of the arm, in photons per unit of gain.

    The arm and the flange are taken at the depth of the scan's plane on the optical axis. Hiding is exact
    only to a cell, and the metal under the patch, 1/2000 of the patch's light, counts as seen.
    """

    def __init__(self, optics: Optics, timing: Timing, bench: Bench) -> None:
        self.bench = bench
        x = np.arange(-REACH_X, REACH_X, CELL) + CELL / 2
        y = np.arange(-REACH_Y, REACH_Y, CELL) + CELL / 2
        self._tangents = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        directions = np.column_stack([self._tangents, np.ones(len(self._tangents))])
        response = optics.response(directions)
        kept = response.max(axis=0) > 1e-3 * response.max()
        self._tangents, directions, response = self._tangents[kept], directions[kept], response[:, kept]

        def light(depth_m: float, reflectance: float) -> np.ndarray:
            """(cells, P·T) photons by bin from a plane at this depth that fills every cell."""
            range_m, cosine = _plane(bench, directions, depth_m)
            # A cell of tangents fills cos³ of its area in steradians; seen from r it covers that times r² /
            # cosine.
            solid_angle = CELL**2 / np.linalg.norm(directions, axis=1) ** 3
            photons = returned(response, matt(reflectance, cosine), solid_angle * range_m**2 / cosine, range_m)
            times = arrival(range_m[:, None], timing.time_zero_s)
            pulses = timing.pulse.in_bins(times, timing.bins, timing.bin_width_s)
            return (photons.T[..., None] * pulses).reshape(len(directions), -1).astype(np.float32)

        cloth = light(bench.patch_range_m + CLOTH_BEHIND_M, CLOTH_REFLECTANCE)
        self._shape = (len(response), timing.bins)
        self._cloth = cloth.sum(axis=0, dtype=float)
        self._arm_depth_m = bench.patch_range_m + arm.ARM_BEHIND_M
        self._arm = light(self._arm_depth_m, ARM_REFLECTANCE) - cloth
        self._flange = light(bench.patch_range_m + arm.FLANGE_BEHIND_M, FLANGE_REFLECTANCE) - cloth

    def photons(self, centres_m: np.ndarray) -> np.ndarray:
        """(F, P, T) photons per unit of gain with the flange's centre at (F, 3) in the camera's frame."""
        shoulder = centres_m.copy()
        shoulder[:, :2] += arm.ARM_LENGTH_M * arm.arm_direction(self.bench, centres_m)
        behind = (0, 0, arm.ARM_BEHIND_M)
        link = self._covered(centres_m + behind, shoulder + behind, arm.HOUSING_M)
        flange = self._covered(centres_m, centres_m, arm.FLANGE_M)
        seen = self._cloth + (link * (1 - flange)) @ self._arm + flange @ self._flange
        return seen.reshape(-1, *self._shape)

    def _covered(self, start_m: np.ndarray, end_m: np.ndarray, radius_m: float) -> np.ndarray:
        """(F, cells) share of each cell that is hidden by a bar with round ends between (F, 3)."""
        start, end = self.bench.to_lidar(start_m), self.bench.to_lidar(end_m)
        radius = radius_m / start[:, 2:]
        start, end = start[:, :2] / start[:, 2:], end[:, :2] / end[:, 2:]
        along = (end - start)[:, None]
        away = self._tangents - start[:, None]
        length = np.maximum(np.square(along).sum(axis=-1), 1e-12)
        place = np.clip((away * along).sum(axis=-1) / length, 0, 1)[..., None]
        distance = np.linalg.norm(away - place * along, axis=-1)
        return np.clip((radius - distance) / CELL + 0.5, 0, 1).astype(np.float32)


def _plane(bench: Bench, directions: np.ndarray, depth_m: float) -> tuple[np.ndarray, np.ndarray]:
    """(cells,) range and cosine of incidence where LiDAR directions meet the plane at this camera depth."""
    normal = bench.lidar_from_camera[:3, 2]
    slant = directions @ normal / np.linalg.norm(directions, axis=1)
    return (depth_m - bench.lidar_position_m[2]) / slant, slant
