"""A scan while it runs: camera, patch, histograms, and the maps as they grow."""

import numpy as np
import rerun as rr
from rerun import blueprint as rrb

from viewers.overlay import zone_colours

JPEG_QUALITY = 80
RADIUS_PX = 5.0
# Of the brightest so far: what is fainter is not drawn.
FAINT = 0.03


class LiveScan:
    """Logs a scan position by position to a rerun recording; memory does not grow here.

    zone_grid: rows and columns of zones. image_size: of the camera's pictures, width and height.
    """

    def __init__(
        self, recording: rr.RecordingStream, zone_grid: tuple[int, int], image_size: tuple[int, int] = (848, 480)
    ) -> None:
        self._recording, self._grid = recording, zone_grid
        rows, columns = zone_grid
        self._zones = [f"{r}_{c}" for r in range(rows) for c in range(columns)]
        self._colours = (255 * zone_colours(len(self._zones))).astype(np.uint8)
        self._brightest = np.ones(len(self._zones))
        self._floor: np.ndarray | None = None
        self._count = 0
        # The maps fill the image, whatever is seen of them so far.
        frame = rr.Boxes2D(mins=[[0, 0]], sizes=[image_size], colors=[[90, 90, 90]])
        recording.log("maps/image", frame, static=True)

    def push(self, counts: np.ndarray, rgb: np.ndarray | None, patch_px: tuple[float, float, float] | None, label: str):
        """Show a position.

        counts: (P, T). rgb: (H, W, 3), None without a picture. patch_px: centre and radius of the patch, None where it
        was not found. label: of the pass.
        """
        self._recording.set_time("position", sequence=self._count)
        log = self._recording.log
        for zone, histogram, colour in zip(self._zones, counts, self._colours, strict=True):
            log(f"lidar/zone/{zone}", rr.BarChart(histogram, color=colour))
        if rgb is not None:
            log("camera/rgb", rr.Image(np.ascontiguousarray(rgb)).compress(jpeg_quality=JPEG_QUALITY))
        if patch_px is not None and label == "patch":
            x, y, radius = patch_px
            log("camera/patch", rr.Points2D([[x, y]], radii=radius, colors=[255, 255, 0, 90], draw_order=40))
            self._grow(counts, (x, y))
        self._count += 1

    def _grow(self, counts: np.ndarray, at_px: tuple[float, float]) -> None:
        """Add a dot to the map of each zone: how far its histogram rises above the lowest it ever was, bin by bin."""
        floor = counts.astype(float)
        self._floor = floor if self._floor is None else np.minimum(self._floor, floor)
        response = (counts - self._floor).max(axis=1)
        self._brightest = np.maximum(self._brightest, response)
        share = response / self._brightest
        for zone, colour, of_peak in zip(self._zones, self._colours, share, strict=True):
            if of_peak > FAINT:
                rgba = [*colour.tolist(), int(255 * of_peak)]
                self._recording.log(
                    f"maps/{zone}", rr.Points2D([at_px], radii=RADIUS_PX, colors=[rgba], draw_order=20 + of_peak)
                )


def live_scan_blueprint(zone_grid: tuple[int, int]) -> rrb.Blueprint:
    """Camera with the patch, the maps so far, and the histograms; panels lie where their zones look."""
    rows, columns = zone_grid
    mirrored = [f"{r}_{c}" for r in range(rows) for c in reversed(range(columns))]
    so_far = rrb.VisibleTimeRange(
        "position", start=rrb.TimeRangeBoundary.infinite(), end=rrb.TimeRangeBoundary.cursor_relative()
    )
    camera = rrb.Spatial2DView(origin="camera", name="camera and patch")
    maps = rrb.Spatial2DView(origin="maps", name="maps so far", time_ranges=[so_far])
    histograms = rrb.Grid(
        *(rrb.BarChartView(origin=f"lidar/zone/{zone}", name=f"zone {zone.replace('_', ',')}") for zone in mirrored),
        grid_columns=columns,
    )
    return rrb.Blueprint(
        rrb.Horizontal(rrb.Vertical(camera, maps), histograms),
        rrb.TimePanel(state="collapsed", timeline="position"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        auto_views=False,
    )
