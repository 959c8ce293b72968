"""Maps as the sensor's own optics would make them: SPADs behind a lens, the flood, the blur of the patch."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.special import ndtr

from physics.flood import tmf882x_flood
from physics.optics import Optics
from physics.spads import FOCAL_M, PITCH_X_M, PITCH_Y_M, SpadMap

# Parameters, in this order: a projective map of the image to tangents (8), blur and active area of a SPAD along x
# and y as logarithms (4), centre, widths (logarithms) and powers of the flood (6).
GEOMETRY, BLUR, ACTIVE, FLOOD = slice(0, 8), slice(8, 10), slice(10, 12), slice(12, 18)
SIZE = 18
# How far a device may be from the nominal one, standard deviations; the geometry is all but free.
SPREAD = np.array([0.3] * 6 + [0.1] * 2 + [0.4] * 2 + [0.1] * 2 + [0.05] * 2 + [0.2] * 2 + [0.5] * 2)
STEP = 1e-4
NEGLIGIBLE = 1e-6
ENVELOPE_BLUR = 1.0  # of a SPAD's pitch: how far light may stray from where the model has it
NODES = 5  # of the quadrature across the patch: exact for polynomials up to degree 9


@dataclass(frozen=True, eq=False)
class SpadOptics:
    """The model of one SPAD map seen through an unknown geometry.

    centre_px (2,), scale_px: image points are centred and scaled so before the projective map. radius_px: the patch's.
    """

    spads: SpadMap
    centre_px: np.ndarray
    scale_px: float
    radius_px: float

    def nominal(self) -> np.ndarray:
        """(18,) parameters of a nominal device that looks along the camera's axis; its geometry is a placeholder."""
        optics = Optics(self.spads, tmf882x_flood())
        blur = np.log([optics.blur_m / FOCAL_M] * 2)
        active = np.log(np.array(optics.active_m) / (PITCH_X_M, PITCH_Y_M))
        widths = np.log(np.tan(np.radians(optics.flood.half_width_deg)))
        return np.concatenate([np.zeros(8), blur, active, [0, 0], widths, optics.flood.power])

    def maps(self, values: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(P, N) responses at N image points, 1 for all the patch's light on SPADs of the zone at the flood's top."""
        tangents, reach = self._tangents(values, x, y)
        return self._core(values, tangents, reach) * self._flood(values, tangents)

    def envelope(self, values: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """(P, N) where a zone may respond though the model's details be wrong: without gaps, blurred further."""
        blurred = values.copy()
        blurred[ACTIVE] = 0
        blurred[BLUR] = np.log(ENVELOPE_BLUR * PITCH_X_M / FOCAL_M)
        return self.maps(blurred, x, y)

    def derivatives(self, values: np.ndarray, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The maps (P, N) and their derivatives (18, P, N) by the parameters."""
        (tan_x, tan_y), reach = self._tangents(values, x, y)
        core, flood = self._core(values, (tan_x, tan_y), reach), self._flood(values, (tan_x, tan_y))
        found = np.empty((SIZE, *core.shape))
        moved = [
            (self._core(values, t, reach) * self._flood(values, t) - core * flood) / STEP
            for t in ((tan_x + STEP, tan_y), (tan_x, tan_y + STEP))
        ]
        u, v = (x - self.centre_px[0]) / self.scale_px, (y - self.centre_px[1]) / self.scale_px
        below = 1 + values[6] * u + values[7] * v
        for i, factor in enumerate((1 / below, u / below, v / below)):
            found[i], found[3 + i] = moved[0] * factor, moved[1] * factor
        for i, factor in enumerate((u, v)):
            found[6 + i] = -(moved[0] * tan_x + moved[1] * tan_y) * factor / below
        for i in range(BLUR.start, SIZE):
            there = values.copy()
            there[i] += STEP
            if i < FLOOD.start:
                found[i] = (self._core(there, (tan_x, tan_y), reach) - core) / STEP * flood
            else:
                found[i] = core * (self._flood(there, (tan_x, tan_y)) - flood) / STEP
        return core * flood, found

    def _tangents(self, values: np.ndarray, x: np.ndarray, y: np.ndarray) -> tuple[tuple, list]:
        """Tangents (x, y) of the directions of image points, and the patch's half widths along both."""
        u, v = (x - self.centre_px[0]) / self.scale_px, (y - self.centre_px[1]) / self.scale_px
        below = 1 + values[6] * u + values[7] * v
        tangents, reach = [], []
        for a, along_u, along_v in (values[0:3], values[3:6]):
            tangent = (a + along_u * u + along_v * v) / below
            # A disc's shadow on one axis: its radius times the gradient.
            slope = np.hypot(along_u - tangent * values[6], along_v - tangent * values[7]) / np.abs(below)
            tangents.append(tangent)
            reach.append(slope * self.radius_px / self.scale_px)
        return tuple(tangents), reach

    def _core(self, values: np.ndarray, tangents: tuple, reach: list) -> np.ndarray:
        """(P, N) share of the patch's light on the zone's SPADs, the disc taken as the product of its shadows."""
        across, along = self._strips(values, tangents, reach)
        masks = np.zeros(self.spads.masks.shape)
        masks[self.spads.masks] = 1 + self.mixing @ values[SIZE:]
        by_row = (masks.reshape(-1, masks.shape[2]) @ across).reshape(*masks.shape[:2], -1)
        return np.einsum("prn,rn->pn", by_row, along)

    def _strips(self, values: np.ndarray, tangents: tuple, reach: list) -> tuple[np.ndarray, np.ndarray]:
        """(18, N) and (12, N) shares of the patch's light on columns and rows of SPADs."""
        blur = np.exp(values[BLUR])
        width = np.exp(values[ACTIVE]) * (PITCH_X_M / FOCAL_M, PITCH_Y_M / FOCAL_M)
        across = _on_strips(tangents[0], self.spads.tan_x, width[0], blur[0], reach[0])
        return across, _on_strips(tangents[1], self.spads.tan_y, width[1], blur[1], reach[1])

    def by_weight(self, values: np.ndarray, x: np.ndarray, y: np.ndarray) -> list[sparse.csr_array]:
        """For each zone (N, W) derivatives by the weights of its SPADs."""
        tangents, reach = self._tangents(values, x, y)
        across, along = self._strips(values, tangents, reach)
        zone, row, column = np.nonzero(self.spads.masks)
        spads = across[column] * along[row] * self._flood(values, tangents)
        spads[spads < NEGLIGIBLE] = 0
        return [sparse.csr_array(spads[zone == p].T) @ self.mixing[zone == p] for p in range(len(self.spads.masks))]

    @cached_property
    def mixing(self) -> sparse.csr_array:
        """(S, W) how the weights of SPADs are made of those of rows, of a zone's rows and their own."""
        zone, row, _ = np.nonzero(self.spads.masks)
        groups = [row, np.unique(zone * 100 + row, return_inverse=True)[1], np.arange(len(row))]
        return sparse.csr_array(
            sparse.hstack([sparse.csr_array((np.ones(len(g)), (np.arange(len(g)), g))) for g in groups])
        )

    @property
    def weights(self) -> list[int]:
        """Number of weights by kind."""
        zone, row, _ = np.nonzero(self.spads.masks)
        return [int(row.max() + 1), len(np.unique(zone * 100 + row)), len(row)]

    def _flood(self, values: np.ndarray, tangents: tuple) -> np.ndarray:
        """(N,) the flood, a super-Gaussian in both tangents."""
        x, y, width_x, width_y, power_x, power_y = values[FLOOD]
        fall_x = np.abs((tangents[0] - x) / np.exp(width_x)) ** power_x
        return np.exp(-fall_x - np.abs((tangents[1] - y) / np.exp(width_y)) ** power_y)


def _on_strips(tangent: np.ndarray, centres: np.ndarray, width: float, blur: float, reach: np.ndarray) -> np.ndarray:
    """(strips, N) share of a patch of half width `reach` (N,), blurred, on strips around `centres`.

    The shadow of a disc is a semicircle: quadrature of Gauss and Chebyshev, second kind (Abramowitz & Stegun 25.4.40).
    """
    angle = np.pi * np.arange(1, NODES + 1) / (NODES + 1)
    weights = 2 / (NODES + 1) * np.sin(angle) ** 2
    total = np.zeros((len(centres), len(tangent)))
    for node, weight in zip(np.cos(angle), weights, strict=True):
        at = (tangent + reach * node - centres[:, None]) / blur
        total += weight * (ndtr(at + width / 2 / blur) - ndtr(at - width / 2 / blur))
    return total
