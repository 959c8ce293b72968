"""A patch scan becomes response maps: the whole of the published pipeline in one function."""

import json
from dataclasses import dataclass, replace
from importlib.metadata import version

import numpy as np

from calibrate.completed import completed, left_out
from calibrate.flags import describe, flag_samples
from calibrate.kernel import Kernel, fit_kernel
from calibrate.patch_track import PatchTrack, find_patches
from calibrate.plan import ScanPlan
from calibrate.positions import Positions, scan_positions
from calibrate.responses import Responses, responses
from calibrate.space import ScanGeometry
from calibrate.window import Window, choose_window
from recordings.maps import ResponseMaps
from recordings.progress import Progress, silent
from recordings.recording import Recording
from recordings.refusal import Refusal

# What a recording's meta may say about the sensor and its setting that belongs to the maps, too.
PROVENANCE = ("sensor", "mode", "ranging", "firmware", "temperature_c", "laser_cycles", "made_by")


@dataclass(frozen=True, eq=False)
class Calibration:
    """Response maps and how they were found.

    maps: what is saved; where a scan left positions of its grid out, completed by predictions, which come last.
    track: patch centres per frame. positions: which of them became samples. window: the bins G.
    found: responses and errors. kernel: continuous maps, None where there are too few samples.
    """

    maps: ResponseMaps
    track: PatchTrack
    positions: Positions
    window: Window
    found: Responses
    kernel: Kernel | None


def calibrate(
    scan: Recording,
    background: Recording | None = None,
    *,
    plan: ScanPlan | None = None,
    window: tuple[int, int] | None = None,
    patch_radius_px: float | None = None,
    patch_depth_m: float | None = None,
    baseline_m: tuple[float, float, float] | None = None,
    progress: Progress = silent,
) -> Calibration:
    """Response of every zone at every patch position, with errors and flags (Behari & Raskar 2026, Eq. 2 and 3).

    scan, background: the same captures with and without the patch; without background nothing is subtracted.
    plan: which frames rest at which cell of the grid; from the recording where None, else every frame is a position.
    window: first and last bin of G; chosen from the data where None. patch_radius_px: found where None.
    patch_depth_m, baseline_m: distance of the patch's plane along the optical axis and position of the LiDAR in the
    camera's frame; with the recording's intrinsics they put the maps into space.

    Raises `Refusal` where the two scans do not match, no capture shows the patch, or there is no light of it.
    """
    _check_pair(scan, background)
    plan = plan or ScanPlan.from_meta(scan.meta)
    if plan is not None and plan.count != len(scan.counts):
        raise Refusal(f"scan plan: {plan.count} frames, the recording has {len(scan.counts)}; expected them to agree")
    track = _patch_centres(scan, plan, patch_radius_px, progress)
    positions = scan_positions(track, plan)
    dark = None if background is None else background.counts
    bins = scan.counts.shape[2]
    chosen = Window.checked(*window, bins) if window else choose_window(scan.counts, dark)
    found = responses(scan.counts, dark, chosen, positions.frames)
    maps = ResponseMaps(
        responses=found.value.reshape(*scan.zone_grid, -1).astype(np.float32),
        xs=positions.x_px.astype(np.float32),
        ys=positions.y_px.astype(np.float32),
        cap_ids=np.array([f"{frame:04d}" for frame in positions.frames[:, 0]]),
        sigma=found.sigma.reshape(*scan.zone_grid, -1).astype(np.float32),
        position_sigma_px=positions.sigma_px.astype(np.float32),
        position_confidence=positions.confidence.astype(np.float32),
    )
    kernel = fit_kernel(maps, positions.radius_px) if len(positions.x_px) >= 10 and found.value.any() else None
    outliers = np.zeros(found.value.shape, bool) if kernel is None else kernel.outliers
    flags = flag_samples(scan.counts, dark, scan.laser_cycles, positions.frames, chosen, found, outliers)
    meta = _meta(scan, background is not None, positions, chosen, found, flags)
    meta |= _geometry(scan, patch_depth_m, baseline_m)
    maps = replace(maps, flags=flags.reshape(maps.responses.shape), meta_json=json.dumps(meta))
    if left_out(plan):
        maps = completed(maps, plan, positions)
        kernel = fit_kernel(maps, positions.radius_px)
    return Calibration(maps, track, positions, chosen, found, kernel)


def _check_pair(scan: Recording, background: Recording | None) -> None:
    if not scan.counts.any():
        raise Refusal("counts: all are 0, expected a scan that saw light")
    if background is None:
        return
    if background.counts.shape != scan.counts.shape:
        raise Refusal(
            f"counts: {scan.counts.shape} frames, zones, bins in the scan and {background.counts.shape} in the "
            "background, expected the same captures with and without the patch"
        )
    if not np.array_equal(scan.zone_grid, background.zone_grid):
        raise Refusal(
            f"zone_grid: {scan.zone_grid.tolist()} in the scan and {background.zone_grid.tolist()} in the background, "
            "expected the same sensor mode"
        )
    if not np.isclose(scan.bin_width_s, background.bin_width_s, rtol=1e-6, atol=0):
        raise Refusal(
            f"bin_width_s: {scan.bin_width_s:.4g} s in the scan and {background.bin_width_s:.4g} s in the background, "
            "expected the same range mode"
        )
    lost = [plan.lost if plan else () for plan in (ScanPlan.from_meta(r.meta) for r in (scan, background))]
    if lost[0] != lost[1]:
        apart = sorted(set(lost[0]) ^ set(lost[1]))
        raise Refusal(f"scan plan: frame {apart[0]} was lost in one of the two scans only, expected the same captures")
    if np.array_equal(scan.counts, background.counts):
        raise Refusal("counts: scan and background are identical, expected one with and one without the patch")


def _patch_centres(
    scan: Recording, plan: ScanPlan | None, patch_radius_px: float | None, progress: Progress
) -> PatchTrack:
    if scan.patch_px is not None:
        return PatchTrack.given(scan.patch_px, patch_radius_px or scan.meta.get("patch_radius_px", 0.0))
    if scan.rgb is None:
        raise Refusal("rgb: the recording has neither rgb frames nor patch_px, expected one to place the patch by")
    if len(scan.rgb.shape) == 3:
        raise Refusal("rgb: one picture for the whole recording, expected a frame for every capture")
    return find_patches(scan.rgb, plan, radius_px=patch_radius_px, progress=progress)


def _meta(
    scan: Recording,
    subtracted: bool,
    positions: Positions,
    window: Window,
    found: Responses,
    flags: np.ndarray,
) -> dict:
    """Provenance under the published names, and what the published files leave out."""
    rows, columns = (int(n) for n in scan.zone_grid)
    signal = "patch - background" if subtracted else "patch, nothing subtracted"
    height, width = _image_shape(scan)
    return {name: scan.meta[name] for name in PROVENANCE if name in scan.meta} | {
        "made_with": f"difflidar {version('difflidar')}",
        "background_subtracted": subtracted,
        "bin_min": window.first,
        "bin_max": window.last,
        "window_chosen_by": window.chosen,
        "window_share": round(window.share, 6),
        "window_others": [list(other) for other in window.others],
        "response_definition": f"max over bins {window.first}..{window.last} of clip({signal}, 0)",
        "n_captures": len(positions.x_px),
        "responses_shape": [rows, columns, len(positions.x_px)],
        "left_out": positions.left_out,
        "repeats": int(positions.frames.shape[1]),
        "gain_noise": found.gain_noise,
        "patch_radius_px": positions.radius_px,
        "patch_methods": positions.methods,
        "flagged": describe(flags),
        "image_size": [width, height],
    }


def _image_shape(scan: Recording) -> tuple[int, int]:
    if scan.rgb is not None:
        return int(scan.rgb.shape[-3]), int(scan.rgb.shape[-2])
    width, height = scan.meta.get("image_size", (848, 480))
    return int(height), int(width)


def _geometry(scan: Recording, depth_m: float | None, baseline_m: tuple[float, float, float] | None) -> dict:
    """The maps' place in space, or that they have none."""
    depth = depth_m if depth_m is not None else scan.meta.get("patch_depth_m")
    transform = scan.lidar_from_camera
    if baseline_m is not None:
        if not np.isfinite(baseline_m).all():
            raise Refusal(f"baseline: {tuple(baseline_m)} m found, expected finite metres")
        transform = np.eye(4)
        transform[:3, 3] = -np.asarray(baseline_m, float)
    if depth is None or transform is None or scan.intrinsics is None:
        return {"frame": "image plane"}
    if not depth > 0:
        raise Refusal(f"patch distance: {depth} m found, expected metres above 0")
    return {"frame": "lidar"} | ScanGeometry(_full_size_intrinsics(scan), transform, depth).to_meta()


def _full_size_intrinsics(scan: Recording) -> np.ndarray:
    """The pinhole matrix for the full-size image; x_full = (x + ½) · W_full / W − ½, likewise y."""
    height, width = _image_shape(scan)
    sx, sy = np.array([width, height]) / (scan.image_size if scan.image_size is not None else (width, height))
    scale = np.array([[sx, 0, (sx - 1) / 2], [0, sy, (sy - 1) / 2], [0, 0, 1]])
    return scale @ scan.intrinsics
