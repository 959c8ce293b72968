"""How a calibration session opens: camera with the maps on the left, histograms and maps on the right."""

from rerun import blueprint as rrb


def scan_blueprint(zone_grid: tuple[int, int], timeline: str = "frame") -> rrb.Blueprint:
    """Layout of the entities that `viewers.scan_session` writes.

    The sensor's columns run against the image's, so panels show them mirrored: each lies where its zone looks.
    """
    rows, columns = zone_grid
    mirrored = [f"{r}_{c}" for r in range(rows) for c in reversed(range(columns))]
    so_far = rrb.VisibleTimeRange(
        timeline,
        start=rrb.TimeRangeBoundary.infinite(),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
    camera = rrb.Spatial2DView(
        origin="camera",
        contents=["camera/**", "- camera/scanned"],
        name="camera, patch and response maps",
    )
    progress = rrb.Spatial2DView(
        origin="camera", contents=["camera/scanned"], name="scanned so far", time_ranges=[so_far]
    )
    histograms = rrb.Grid(
        *(rrb.BarChartView(origin=f"lidar/zone/{zone}", name=f"zone {zone.replace('_', ',')}") for zone in mirrored),
        grid_columns=columns,
        name="histograms",
    )
    maps = rrb.Grid(
        *(rrb.Spatial2DView(origin=f"maps/{zone}", name=f"map {zone.replace('_', ',')}") for zone in mirrored),
        grid_columns=columns,
        name="maps",
    )
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(
                camera,
                rrb.Horizontal(
                    progress,
                    rrb.TimeSeriesView(origin="response", name="response of each zone"),
                    column_shares=[1, 1],
                ),
                row_shares=[3, 2],
            ),
            rrb.Vertical(histograms, rrb.Tabs(maps, rrb.TextDocumentView(origin="summary", name="summary"))),
            column_shares=[5, 4],
        ),
        rrb.TimePanel(state="collapsed", timeline=timeline, play_state="playing", fps=60.0),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        auto_views=False,
    )
