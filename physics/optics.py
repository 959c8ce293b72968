"""Where each zone of a TMF882x looks: SPADs behind the lens, times the flood, plus light between zones."""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from physics.flood import Flood, tmf882x_flood
from physics.spads import FOCAL_M, PITCH_X_M, PITCH_Y_M, SpadMap, spad_map
from recordings.refusal import Refusal

# Directions are worked through in blocks of this many, which bounds the memory.
BLOCK = 1 << 13


@dataclass(frozen=True, eq=False)
class Optics:
    """What share of the light from a direction reaches each zone, times how strongly the direction is lit.

    active_m: width and height of a SPAD's active area; the rest of its pitch is blind.
    blur_m: standard deviation of the lens's image of a point. halo_m: that of the light scattered around it.
    halo_share: share of the scattered light that a zone gets of what falls on its own SPADs and between them.
    stray_share: share that it gets of what falls on and between the SPADs of all zones.

    The datasheet gives none of these. They are set so that the maps show what published ones do: dark lines
    between rows but hardly between columns, and under every zone a smooth pedestal of about 1 % of the sum of
    all zones.
    """

    spads: SpadMap
    flood: Flood
    active_m: tuple[float, float] = (14e-6, 29e-6)
    blur_m: float = 4.5e-6
    halo_m: float = 30e-6
    halo_share: float = 0.05
    stray_share: float = 0.01

    @property
    def zone_grid(self) -> tuple[int, int]:
        """Rows and columns of the zones."""
        return self.spads.zone_grid

    def response(self, directions: np.ndarray) -> np.ndarray:
        """(P, ...) response of each zone to light from `directions` (..., 3), continuous in angle.

        The LiDAR's frame is x right, y down, z forward; lengths do not matter, and what is behind is not
        seen. 1 would be all the light on SPADs of the zone, at the flood's plateau.
        """
        directions = np.asarray(directions, float)
        if directions.shape[-1:] != (3,):
            raise Refusal(f"directions has shape {directions.shape}, expected (..., 3)")
        flat = directions.reshape(-1, 3)
        zones = np.empty((len(self.spads.masks), len(flat)))
        for start in range(0, len(flat), BLOCK):
            zones[:, start : start + BLOCK] = self._towards(flat[start : start + BLOCK])
        return zones.reshape(-1, *directions.shape[:-1])

    def _towards(self, flat: np.ndarray) -> np.ndarray:
        """(P, N) response to directions (N, 3)."""
        ahead = flat[:, 2] > 0
        depth = np.where(ahead, flat[:, 2], np.inf)
        tan_x, tan_y = flat[:, 0] / depth, flat[:, 1] / depth
        core = self._on_zones(tan_x, tan_y, self.active_m, self.blur_m)
        halo = self._on_zones(tan_x, tan_y, (PITCH_X_M, PITCH_Y_M), self.halo_m)
        received = (1 - self.halo_share) * core + self.halo_share * halo + self.stray_share * halo.sum(axis=0)
        lit = self.flood.intensity(tan_x, tan_y) * ahead
        return received * lit

    def _on_zones(self, tan_x: np.ndarray, tan_y: np.ndarray, area_m: tuple, blur_m: float) -> np.ndarray:
        """(P, N) fraction of Gaussian spots in N directions that falls on areas of this size at the SPADs."""
        # Rows and columns without a SPAD of any zone take no part.
        rows, columns = self.spads.masks.any(axis=(0, 2)), self.spads.masks.any(axis=(0, 1))
        masks = self.spads.masks[:, rows][:, :, columns].astype(float)
        across = _on_strip(tan_x - self.spads.tan_x[columns, None], area_m[0], blur_m)
        along = _on_strip(tan_y - self.spads.tan_y[rows, None], area_m[1], blur_m)
        # Sum over the columns, then over the rows.
        by_row = (masks.reshape(-1, masks.shape[2]) @ across).reshape(*masks.shape[:2], -1)
        return np.einsum("prn,rn->pn", by_row, along)


def _on_strip(tangent: np.ndarray, width_m: float, blur_m: float) -> np.ndarray:
    """Fraction of a Gaussian spot that falls on a strip of width `width_m`, centred at tangent 0."""
    at = tangent * FOCAL_M
    return ndtr((at + width_m / 2) / blur_m) - ndtr((at - width_m / 2) / blur_m)


def tmf882x_optics(spad_map_id: int = 6, rng: np.random.Generator | None = None) -> Optics:
    """The optics of one device in the SPAD map of this id; `rng` draws its flood's texture if given."""
    return Optics(spad_map(spad_map_id), tmf882x_flood(rng))
