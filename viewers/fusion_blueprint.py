"""How a session of fusion opens: the world and the pictures on the left, what the sensor counted on the right."""

import numpy as np
from rerun import blueprint as rrb

from viewers.footprint_contours import named
from viewers.session_frame import SessionRig

# The eye in the frame of the first camera: behind it, to its right and above; and what it looks at. Metres.
EYE, TARGET, UP = (1.0, -0.8, -0.75), (0.0, 0.05, 1.5), (0.0, -1.0, 0.0)
BACKGROUND = (24, 26, 31)


def fusion_blueprint(rig: SessionRig) -> rrb.Blueprint:
    """Layout of the entities that `viewers.live_view.LiveView` logs.

    The sensor's columns run against the image's, so histograms are shown mirrored: each lies where its zone looks.
    """
    left = [_world(rig)]
    pictures = _pictures(rig)
    if pictures:
        left.append(rrb.Horizontal(*pictures, column_shares=[1.35, 1, 1][: len(pictures)]))
    shares = [5, 2.1] if pictures else [1]
    right = _below(rig) if rig.range_m is None else rrb.Vertical(_histograms(rig), _below(rig), row_shares=[5, 2.6])
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(*left, row_shares=shares),
            right,
            column_shares=[5, 3 if rig.range_m is None else 4],
        ),
        rrb.TimePanel(state="collapsed", timeline="time", play_state="playing", loop_mode="all"),
        rrb.SelectionPanel(state="hidden"),
        rrb.BlueprintPanel(state="hidden"),
        auto_views=False,
    )


def _world(rig: SessionRig) -> rrb.Spatial3DView:
    """Cloud, camera and the way that it has come so far."""
    pose = np.eye(4) if rig.first_pose is None else np.asarray(rig.first_pose, float)
    eye, target = (pose[:3, :3] @ place + pose[:3, 3] for place in (EYE, TARGET))
    up = pose[:3, :3] @ UP
    so_far = rrb.VisibleTimeRange(
        "time", start=rrb.TimeRangeBoundary.infinite(), end=rrb.TimeRangeBoundary.cursor_relative()
    )
    return rrb.Spatial3DView(
        origin="world",
        name="fused cloud, camera and its track",
        background=BACKGROUND,
        line_grid=False,
        eye_controls=rrb.EyeControls3D(position=eye, look_target=target, eye_up=up),
        overrides={"world/trajectory": rrb.VisibleTimeRanges([so_far])},
    )


def _pictures(rig: SessionRig) -> list:
    """The camera's image with the footprints, depth, and how far to believe it."""
    shown = []
    if rig.has_pictures or rig.footprints is not None:
        shown.append(rrb.Spatial2DView(origin="world/rig/camera", name="camera, where zones look"))
    if rig.has_depth:
        depth = rrb.Spatial2DView(origin="fused/depth", name="depth")
        recorded = rrb.Spatial2DView(origin="recorded_depth", name="recorded depth")
        shown.append(rrb.Tabs(depth, recorded, active_tab=0) if rig.has_recorded_depth else depth)
        sigma = rrb.Spatial2DView(origin="fused/sigma", name="uncertainty")
        trust = rrb.Spatial2DView(origin="fused/confidence", name="confidence")
        shown.append(rrb.Tabs(sigma, trust, active_tab=0))
    elif rig.has_recorded_depth:
        shown.append(rrb.Spatial2DView(origin="recorded_depth", name="recorded depth"))
    return shown


def _histograms(rig: SessionRig) -> rrb.Grid:
    rows, columns = rig.zone_grid
    mirrored = [f"{row}_{column}" for row in range(rows) for column in reversed(range(columns))]
    views = [
        rrb.BarChartView(origin=f"lidar/zone/{zone}", name=f"zone {name}", plot_legend=rrb.PlotLegend(visible=False))
        for zone, name in zip(mirrored, named(mirrored), strict=True)
    ]
    return rrb.Grid(*views, grid_columns=columns, name="histograms")


def _below(rig: SessionRig) -> rrb.Tabs:
    """What is read less often, a tab each."""
    tabs = [rrb.TimeSeriesView(origin="depth_of_zone", name="strongest surface of each zone (m)")]
    if rig.has_residuals:
        residual = rrb.TensorView(
            origin="residual",
            name="residual, zone by bin",
            scalar_mapping=rrb.TensorScalarMapping(colormap="CyanToYellow", mag_filter="nearest"),
            slice_selection=rrb.TensorSliceSelection(width=1, height=0),
            view_fit="fill",
        )
        tabs.insert(0, residual)
    if rig.has_latency:
        tabs.insert(0, rrb.TimeSeriesView(origin="latency", name="from the sensor's answer to the cloud (ms)"))
    about = rrb.TextDocumentView(origin="about", name="how to read this")
    return rrb.Tabs(*tabs, about, active_tab=0)
