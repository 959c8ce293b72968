"""The picture of a calibration: every zone's map in its own colour over the camera image."""

from pathlib import Path

import cv2
import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from recordings.atomic import written_aside

DARKENED = 0.7  # of the camera image's brightness, so that the maps stand out
OPAQUE = 0.9
FAINT = 0.025  # opacity below which a map is not drawn
QUANTILES = (1, 99.5)  # of all responses: black and full colour


def zone_colours(zones: int) -> np.ndarray:
    """(P, 3) colours in 0 to 1, equally spaced in hue."""
    return mpl.colormaps["hsv"](np.arange(zones) / zones)[:, :3]


def zone_opacity(images: np.ndarray) -> np.ndarray:
    """(P, h, w) opacity of each zone's map image: 0 where nothing was measured or the map is faint."""
    low, high = np.nanpercentile(images, QUANTILES)
    opacity = OPAQUE * np.clip((np.nan_to_num(images, nan=low) - low) / max(high - low, 1e-12), 0, 1)
    return np.where(opacity < FAINT, 0, opacity)


def overlay(rgb: np.ndarray, images: np.ndarray) -> np.ndarray:
    """(H, W, 3) uint8: the camera image `rgb` (H, W, 3), darkened, under the zones' map images (P, h, w).

    Colours mix by opacity, C = Σ c·a / Σ a, and cover by A = 1 − exp(−Σ a), as in the published figures.
    """
    size = rgb.shape[1], rgb.shape[0]
    opacity = np.stack(
        [cv2.resize(a.astype(np.float32), size, interpolation=cv2.INTER_LINEAR) for a in zone_opacity(images)]
    )
    total = opacity.sum(axis=0)
    mixed = np.einsum("phw,pc->hwc", opacity, zone_colours(len(images))) / np.maximum(total, 1e-9)[..., None]
    cover = (1 - np.exp(-total))[..., None]
    return np.clip(255 * cover * mixed + (1 - cover) * DARKENED * rgb, 0, 255).astype(np.uint8)


def save_overlay(path: str | Path, rgb: np.ndarray, images: np.ndarray, zone_grid: tuple[int, int]) -> None:
    """Write the overlay, and each zone's map beside it, as a PNG.

    The sensor's columns run against the image's, so the small maps are shown with their columns mirrored: each lies
    where its zone looks. Nothing but the display is mirrored.
    """
    rows, columns = zone_grid
    figure = Figure(figsize=(13, 4.2), dpi=120, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    left, right = figure.subfigures(1, 2, width_ratios=(1, 1))
    axes = left.subplots()
    axes.imshow(overlay(rgb, images))
    axes.set(xlabel="x (px)", ylabel="y (px)", title="response maps over the camera image")
    colours = zone_colours(rows * columns)
    extent = (-0.5, rgb.shape[1] - 0.5, rgb.shape[0] - 0.5, -0.5)
    panels = right.subplots(rows, columns, squeeze=False)
    for p, image in enumerate(images):
        row, column = divmod(p, columns)
        panel = panels[row, columns - 1 - column]
        shade = mpl.colors.LinearSegmentedColormap.from_list("zone", ["black", colours[p], "white"])
        peak = np.nanmax(image)
        panel.imshow(image / (peak if peak > 0 else 1), cmap=shade, vmin=0, vmax=1, extent=extent)
        panel.set(xticks=[], yticks=[])
        panel.set_title(f"zone {row},{column}   peak {peak:.3g}", fontsize=8)
        panel.set_facecolor("0.85")
    right.suptitle("each zone, divided by its peak (columns mirrored for display)", fontsize=10)
    with written_aside(path) as aside, aside.open("wb") as file:
        canvas.print_png(file)
