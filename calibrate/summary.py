"""What a calibration found, in figures per zone and in sentences a person can act on."""

from dataclasses import dataclass

import numpy as np

from calibrate.calibration import Calibration
from calibrate.consistency import centroids
from calibrate.flags import Flag, describe
from calibrate.support import supports


@dataclass(frozen=True)
class ZoneSummary:
    """One zone: peak and its error in counts, median noise limit, support in px², centroid, samples with a flag."""

    row: int
    column: int
    peak: float
    peak_sigma: float
    noise: float
    support_px2: float
    centroid_px: tuple[float, float]
    flagged: int


@dataclass(frozen=True)
class Summary:
    """Zones and sentences."""

    zones: list[ZoneSummary]
    sentences: list[str]


def summarise(result: Calibration, threshold: float) -> Summary:
    """The figures of each zone, and what to know before the maps are believed."""
    maps, found = result.maps, result.found
    columns = maps.zone_grid[1]
    area = np.zeros(len(found.value)) if result.kernel is None else supports(result.kernel, threshold).area_px2
    xy = np.stack([maps.xs, maps.ys], axis=1).astype(float)
    values = maps.by_zone.astype(float)
    total = values.sum(axis=1, keepdims=True)
    middle = np.where(total > 0, centroids(np.where(total > 0, values, 1), xy), np.nan)
    # Being dark far from its footprint is no fault of a sample, nor is being predicted.
    suspicious = maps.flags.reshape(values.shape) & ~np.uint8(Flag.NO_SIGNAL | Flag.PREDICTED)
    zones = []
    for p, value in enumerate(found.value):
        k = int(value.argmax())
        zones.append(
            ZoneSummary(
                row=p // columns,
                column=p % columns,
                peak=float(value[k]),
                peak_sigma=float(found.sigma[p, k]),
                noise=float(np.median(found.noise_limit[p])),
                support_px2=float(area[p]),
                centroid_px=(float(middle[p, 0]), float(middle[p, 1])),
                flagged=int(np.count_nonzero(suspicious[p])),
            )
        )
    return Summary(zones, _sentences(result, threshold))


def _sentences(result: Calibration, threshold: float) -> list[str]:
    positions, window, maps = result.positions, result.window, result.maps
    said = [
        f"Patch seen at {len(positions.x_px)} positions, radius {positions.radius_px:.2f} px, centre known to "
        f"{np.median(positions.sigma_px):.2f} px (median); frames by method: "
        + ", ".join(f"{count} {method}" for method, count in sorted(positions.methods.items())),
        f"Window: bins {window.first} to {window.last}, "
        + ("given by the user." if window.chosen == "user" else f"holds {window.share:.1%} of the significant peaks."),
        f"Supports are where the map reaches {threshold:g} of the zone's peak.",
    ]
    if positions.left_out:
        shown = ", ".join(positions.left_out[:8]) + (", …" if len(positions.left_out) > 8 else "")
        said.append(f"{len(positions.left_out)} captures left out, no patch seen in them: {shown}")
    for first, last, share in window.others[:3]:
        said.append(
            f"Light that came only with the patch also lies in bins {first} to {last} ({share:.1%} of the peaks)."
        )
    if predicted := maps.meta.get("predicted"):
        said.append(
            f"{predicted} positions of the grid were not visited; the maps hold there what a model of the sensor's "
            "optics, fitted to those that were, predicts, with its errors."
        )
    flagged = {name: n for name, n in describe(maps.flags).items() if name not in ("no_signal", "predicted")}
    if flagged:
        said.append("Flagged samples: " + ", ".join(f"{n} {name}" for name, n in flagged.items()))
    if dead := [f"{p // maps.zone_grid[1]},{p % maps.zone_grid[1]}" for p in np.flatnonzero(~found_any(result))]:
        said.append(f"Zones that never respond: {'; '.join(dead)}")
    if maps.meta["frame"] == "image plane":
        said.append(
            "These are image-plane maps, true at the distance of this scan: give --patch-distance and --baseline, and "
            "record the camera's intrinsics, to place them in space."
        )
    return said


def found_any(result: Calibration) -> np.ndarray:
    """(P,) whether a zone responds anywhere above its noise."""
    return (result.found.value > result.found.noise_limit).any(axis=1)
