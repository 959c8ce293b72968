"""ResponseMaps: where in the image each zone looks, sampled at the positions of a scan."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from recordings.checks import check_maps


@dataclass(frozen=True, eq=False)
class ResponseMaps:
    """Responses of rows × cols zones at K scan positions in the full-size image.

    responses: (rows, cols, K) counts, background-subtracted peak (Behari & Raskar 2026, Eq. 2), not normalised.
    xs, ys: (K,) pixels of the full-size image, pixel centres at integers.
    cap_ids: (K,) text, which capture each position came from.
    meta_json: JSON text; `meta` is what it says. `image_size` there is width, height; 848 × 480 where absent.
    sigma: (rows, cols, K) counts, standard error of each response; None where unknown.
    flags: (rows, cols, K) uint8, bits of `calibrate.flags`; None where nothing was checked.
    position_sigma_px: (K,) standard error of each patch centre; None where unknown.
    position_confidence: (K,) 0 to 1, how much of the patch the image showed there; None where unknown.

    Raises `Refusal` with one sentence naming the array, the value at fault and what was expected.
    """

    responses: np.ndarray
    xs: np.ndarray
    ys: np.ndarray
    cap_ids: np.ndarray
    meta_json: str = "{}"
    sigma: np.ndarray | None = None
    flags: np.ndarray | None = None
    position_sigma_px: np.ndarray | None = None
    position_confidence: np.ndarray | None = None

    def __post_init__(self) -> None:
        check_maps(self)

    @property
    def meta(self) -> dict[str, Any]:
        """What `meta_json` says."""
        return json.loads(self.meta_json)

    @property
    def zone_grid(self) -> tuple[int, int]:
        """Rows and columns of the zones."""
        return self.responses.shape[:2]

    @property
    def image_size(self) -> tuple[int, int]:
        """Width and height of the full-size image, pixels."""
        width, height = self.meta.get("image_size", (848, 480))
        return int(width), int(height)

    @property
    def by_zone(self) -> np.ndarray:
        """(P, K) responses, zones row-major."""
        return self.responses.reshape(-1, self.responses.shape[2])

    @property
    def normalised(self) -> np.ndarray:
        """(P, K) peak-normalised maps (Eq. 3): each zone divided by its own largest response."""
        peaks = self.by_zone.max(axis=1, keepdims=True)
        return self.by_zone / np.where(peaks > 0, peaks, 1)
