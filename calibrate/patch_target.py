"""What the patch of a scan looks like, learnt from a few frames, and where a frame shows it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calibrate.patch_circle import Expected
from calibrate.patch_edge import Disc, fit_disc
from calibrate.patch_find import SEARCH_PX, candidates, plausible

LEAST_SIGMA_PX = 0.03
# Fewer whole discs than this do not tell how the radius varies over the image.
FEW, FEW_SIGMA = 12, 0.03
WHOLE = 0.95
# A disc is the patch where its radius differs by less than a pixel or than these standard deviations of the learnt
# one, and its contrast is more than a share of the usual. It is clearly the patch where most of its rim is seen, and
# not much rougher than usual.
RADIUS_PX, RADIUS_SIGMAS = 1.0, 4.0
FAINT = 0.25
CLEAR, ROUGH = 0.6, 5.0
TRIES = 3


@dataclass(frozen=True)
class Target:
    """The patch's radius, which varies slightly over the image where the scan's plane is tilted, and its rim.

    radius: (3,) pixels at the image's centre, and pixels per image width along x and y. radius_sigma_px: scatter.
    noise_px: usual roughness of the rim per ray, whose long waves a short arc would not show. contrast: counts.
    size: width and height of the image.
    """

    radius: np.ndarray
    radius_sigma_px: float
    noise_px: float
    contrast: float
    size: tuple[int, int]

    def radius_px(self, x_px: float, y_px: float) -> float:
        """Expected radius at a place in the image."""
        return float(_place(np.array([[x_px, y_px]]), self.size)[0] @ self.radius)

    def is_shown_by(self, disc: Disc) -> bool:
        """Whether a disc has the patch's radius and contrast, and the image supports it."""
        off = abs(disc.radius_px - self.radius_px(disc.x_px, disc.y_px))
        alike = off < max(RADIUS_PX, RADIUS_SIGMAS * self.radius_sigma_px)
        return plausible(disc) and alike and disc.contrast > FAINT * self.contrast

    def is_clearly_shown_by(self, disc: Disc) -> bool:
        """The same, where the place says nothing: a whole image holds many places to be wrong at."""
        return self.is_shown_by(disc) and disc.confidence > CLEAR and disc.noise_px < ROUGH * self.noise_px


def learn_target(discs: Sequence[Disc], size: tuple[int, int]) -> Target:
    """The target from discs that are the patch, at least one; those that the image's border cuts count least."""
    whole = [disc for disc in discs if disc.arc >= WHOLE] or list(discs)
    radius = np.array([disc.radius_px for disc in whole])
    design = _place(np.array([(disc.x_px, disc.y_px) for disc in whole]), size)
    fitted, sigma = np.array([np.median(radius), 0, 0]), FEW_SIGMA * float(np.median(radius))
    if len(whole) >= FEW:
        for _ in range(3):
            error = radius - design @ fitted
            sigma = max(1.4826 * float(np.median(np.abs(error))), LEAST_SIGMA_PX)
            near = np.abs(error) < 3 * sigma
            fitted = np.linalg.lstsq(design[near], radius[near], rcond=1e-3)[0]
    noise, contrast = (float(np.median([getattr(disc, name) for disc in whole])) for name in ("noise_px", "contrast"))
    return Target(fitted, sigma, noise, contrast, size)


def locate(grey: np.ndarray, target: Target, at_px: np.ndarray, margin_px: float) -> Disc | None:
    """The patch in an image (H, W) uint8 within `margin_px` of a place (2,), along x and along y, or None."""
    radius = target.radius_px(*at_px)
    expected = Expected(radius, target.radius_sigma_px, target.noise_px)
    margin = int(np.ceil(margin_px))
    corner = tuple(int(side) for side in np.round(at_px) - margin)
    for spot in candidates(grey, [radius], corner, (2 * margin + 1, 2 * margin + 1), TRIES):
        search = min(SEARCH_PX, radius / 2)
        disc = fit_disc(grey, spot.x_px, spot.y_px, expected, search)
        if disc and target.is_shown_by(disc) and np.abs((disc.x_px, disc.y_px) - at_px).max() <= margin_px + 1:
            return disc
    return None


def _place(at_px: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """(N, 3) one, and places (N, 2) from the image's centre in image widths."""
    return np.column_stack([np.ones(len(at_px)), (at_px - (np.array(size) - 1) / 2) / size[0]])
