"""A pinhole camera put where the sensor is, to carry depth and zones as images."""

from dataclasses import dataclass

import numpy as np

from recordings.importers.tmf8820.zones import Zones

SIDE_PX = 64
# Beyond the zones' edges, as real zones see a little past them.
MARGIN = 1.15


@dataclass(frozen=True, eq=False)
class VirtualCamera:
    """A square pinhole camera at the sensor, its axes the sensor's: x right, y down, z forward.

    intrinsics: (3, 3), pixel centres at integers. size_px: its width and height.
    """

    intrinsics: np.ndarray
    size_px: int

    @property
    def pixel_tangents(self) -> np.ndarray:
        """(size + 1,) tangents at the pixels' edges, the same in x and y."""
        edges = np.arange(self.size_px + 1) - 0.5
        return (edges - self.intrinsics[0, 2]) / self.intrinsics[0, 0]

    @property
    def rays(self) -> np.ndarray:
        """(H, W, 3) ray through each pixel centre, of length 1 along z."""
        tangents = (self.pixel_tangents[1:] + self.pixel_tangents[:-1]) / 2
        x, y = np.meshgrid(tangents, tangents)
        return np.stack([x, y, np.ones_like(x)], axis=-1)


def camera_over(zones: Zones) -> VirtualCamera:
    """The camera that sees all zones and a margin around them."""
    reach = MARGIN * max(np.abs(zones.low).max(), np.abs(zones.high).max())
    focal = SIDE_PX / 2 / reach
    centre = (SIDE_PX - 1) / 2
    return VirtualCamera(np.array([[focal, 0, centre], [0, focal, centre], [0, 0, 1]]), SIDE_PX)


def coverage(camera: VirtualCamera, zones: Zones) -> np.ndarray:
    """(P, H, W) part of each pixel that lies in each zone's rectangle, so that sums are its area."""
    edges = camera.pixel_tangents
    low = np.maximum(edges[:-1], zones.low[..., None])
    high = np.minimum(edges[1:], zones.high[..., None])
    along = np.clip(high - low, 0, None) / np.diff(edges)
    return along[:, 1, :, None] * along[:, 0, None, :]
