"""A calibration as a rerun session: frames, histograms, scan progress and maps on one timeline."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import rerun as rr

from calibrate.calibration import Calibration
from recordings.atomic import written_aside
from recordings.progress import Progress, silent
from recordings.recording import Recording
from viewers.overlay import zone_colours, zone_opacity
from viewers.scan_blueprint import scan_blueprint

JPEG_QUALITY = 85
SHEER = 0.55  # so that the arm and the patch show through the maps
PICTURES = 360  # of the camera, at most: enough to follow the arm, and the file stays small


def save_scan_session(
    path: str | Path,
    scan: Recording,
    result: Calibration,
    images: np.ndarray,
    sentences: Sequence[str],
    progress: Progress = silent,
) -> None:
    """Write a session that opens laid out: camera with patch and maps, histograms, progress, maps.

    images: (P, h, w) map image of each zone over the full-size image, NaN where nothing was measured.
    sentences: what the calibration found, shown as text.
    """
    rows, columns = (int(n) for n in scan.zone_grid)
    zones = [f"{r}_{c}" for r in range(rows) for c in range(columns)]
    with written_aside(path) as aside, rr.RecordingStream("difflidar") as session:
        session.save(str(aside), default_blueprint=scan_blueprint((rows, columns)))
        session.log("summary", rr.TextDocument("\n\n".join(sentences), media_type="text/markdown"), static=True)
        _maps(session, zones, images, result.maps.image_size)
        _histograms(session, zones, scan)
        _patches(session, zones, scan, result)
        if scan.rgb is not None:
            _pictures(session, scan, progress)
        session.flush()
        session.disconnect()


def _indexes(scan: Recording, frames: np.ndarray) -> list[rr.TimeColumn]:
    return [
        rr.TimeColumn("frame", sequence=frames),
        rr.TimeColumn("time", duration=scan.timestamp_s[frames] - scan.timestamp_s[0]),
    ]


def _maps(session: rr.RecordingStream, zones: list[str], images: np.ndarray, size: tuple[int, int]) -> None:
    """Every map as an image of its own, and as a coloured, half-transparent layer over the camera's."""
    opacity, colours = zone_opacity(images), zone_colours(len(zones))
    for p, zone in enumerate(zones):
        peak = np.nanmax(images[p])
        grey = np.nan_to_num(images[p] / (peak if peak > 0 else 1))
        session.log(f"maps/{zone}", rr.Image((255 * np.clip(grey, 0, 1)).astype(np.uint8)), static=True)
        alpha = cv2.resize(opacity[p].astype(np.float32), size, interpolation=cv2.INTER_LINEAR)
        layer = np.empty((size[1], size[0], 4), np.uint8)
        layer[..., :3] = 255 * colours[p][::-1]  # OpenCV encodes blue first
        layer[..., 3] = 255 * SHEER * alpha
        png = cv2.imencode(".png", layer)[1].tobytes()
        session.log(
            f"camera/maps/{zone}",
            rr.EncodedImage(contents=png, media_type="image/png", draw_order=10 + p),
            static=True,
        )


def _histograms(session: rr.RecordingStream, zones: list[str], scan: Recording) -> None:
    colours = (255 * zone_colours(len(zones))).astype(np.uint8)
    for f in _spread(len(scan.counts), PICTURES):
        _at(session, scan, f)
        for p, zone in enumerate(zones):
            session.log(f"lidar/zone/{zone}", rr.BarChart(scan.counts[f, p], color=colours[p]))


def _patches(session: rr.RecordingStream, zones: list[str], scan: Recording, result: Calibration) -> None:
    """The patch in every frame, and how strongly each zone answered to it."""
    positions, maps = result.positions, result.maps
    frames = positions.frames[:, 0]
    order = np.argsort(frames)
    xy = np.stack([positions.x_px, positions.y_px], axis=1)[order]
    normalised = maps.normalised[:, order]  # predictions come after what was measured
    brightest = normalised.max(axis=0)
    heat = (255 * np.stack([brightest, 0.3 + 0 * brightest, 1 - brightest], axis=1)).astype(np.uint8)
    indexes = _indexes(scan, frames[order])
    session.send_columns(
        "camera/patch",
        indexes,
        [*rr.Points2D.columns(positions=xy, radii=np.full(len(xy), positions.radius_px))],
        strict=True,
    )
    session.log("camera/patch", rr.Points2D.from_fields(colors=[255, 255, 0, 90], draw_order=40), static=True)
    columns = rr.Points2D.columns(positions=xy, colors=heat, radii=np.full(len(xy), 4.0))
    session.send_columns("camera/scanned", indexes, [*columns], strict=True)
    colours = (255 * zone_colours(len(zones))).astype(np.uint8)
    for p, zone in enumerate(zones):
        session.log(f"response/{zone}", rr.SeriesLines(colors=colours[p], names=zone.replace("_", ",")), static=True)
        session.send_columns(f"response/{zone}", indexes, rr.Scalars.columns(scalars=normalised[p]), strict=True)


def _pictures(session: rr.RecordingStream, scan: Recording, progress: Progress) -> None:
    frames = _spread(len(scan.rgb), PICTURES)
    for f in progress(frames, len(frames), "pictures for the session"):
        _at(session, scan, f)
        picture = rr.Image(np.ascontiguousarray(scan.rgb[int(f)])).compress(jpeg_quality=JPEG_QUALITY)
        session.log("camera/rgb", picture)


def _at(session: rr.RecordingStream, scan: Recording, frame: int) -> None:
    session.set_time("frame", sequence=int(frame))
    session.set_time("time", duration=float(scan.timestamp_s[frame] - scan.timestamp_s[0]))


def _spread(count: int, most: int) -> np.ndarray:
    """Indices of at most `most` of `count` frames, evenly spread, first and last included."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))
