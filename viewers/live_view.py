"""Frames as they come, into a rerun session: to a viewer that runs, or to a file."""

from typing import Any

import numpy as np
import rerun as rr

from recordings.refusal import Refusal
from viewers.session_frame import SessionFrame, SessionRig
from viewers.session_histograms import Counted, log_charts, log_residual, send_histograms
from viewers.session_panels import WHITE, colours_by_index, log_footprints, log_rig
from viewers.session_pictures import DEPTH_PIXELS, SIGMA_PIXELS, grey, metres, picture, points, thin_cloud

PICTURES_HZ = 10.0
POINTS = 20_000
MOST_WAITING = 32  # frames whose histograms are not sent yet
ALMOST = 1 - 1e-6  # of a period: times are rounded
FRUSTUM_M = 0.35
# Colour scales reach so far beyond what nearly all pixels of the first image have.
HEADROOM, NEARLY_ALL = 1.15, 0.98


class LiveView:
    """Logs frames to a rerun recording; `push` one after another, from any thread, one thread at a time.

    rig: what holds for all frames. recording: where to. pictures_hz: images and clouds are thinned to this rate,
    histograms and depths are not. most_points: of a cloud. prompt: whether histograms go with the
    next pictures; else some frames at a time, which takes less room and time. No more is kept of frames than these
    histograms, so a session may be as long as its file or its viewer allows.
    """

    def __init__(
        self,
        rig: SessionRig,
        recording: rr.RecordingStream,
        pictures_hz: float = PICTURES_HZ,
        most_points: int = POINTS,
        prompt: bool = True,
    ) -> None:
        self._rig, self._recording = rig, recording
        self._period, self._most, self._prompt = 1 / pictures_hz, most_points, prompt
        self._pushed, self._start, self._pictured = 0, rig.start_s, -np.inf
        self._size: tuple[int, int] | None = None
        self._place: np.ndarray | None = None
        self._scales: dict[str, tuple[float, float]] = {}
        self._waiting: list[Counted] = []
        self._by_zone = colours_by_index(len(rig.zones))
        self._begin()

    def moved_to(self, recording: rr.RecordingStream) -> None:
        """Go on in another recording, which gets what holds for all frames, too."""
        self.flush()
        self._recording = recording
        self._begin()

    def push(self, frame: SessionFrame) -> None:
        """Show a frame; what it lacks stays as it was. Frames may come late or out of order."""
        self._expect(frame)
        if self._start is None:
            self._start = frame.timestamp_s
        since = frame.timestamp_s - self._start
        self._recording.set_time("frame", sequence=self._pushed)
        self._recording.set_time("time", duration=since)
        fused = frame.fused
        pose = frame.pose if frame.pose is not None or fused is None else fused.pose
        if pose is not None:
            self._moved(np.asarray(pose, float))
        if frame.latency_s is not None:
            self._log("latency", rr.Scalars(1e3 * frame.latency_s))
        if frame.counts is not None or frame.surface_m is not None:
            self._waiting.append(Counted.of(self._pushed, since, frame))
        self._pushed += 1
        # Absolute: a clock that was set back starts anew.
        due = abs(since - self._pictured) >= self._period * ALMOST
        if due:
            self._pictured = since
            self._pictures(frame, pose)
            if frame.expected is not None and frame.counts is not None:
                log_residual(self._log, frame.counts, frame.expected)
        if (due and self._prompt) or len(self._waiting) >= MOST_WAITING:
            self.flush()

    def _expect(self, frame: SessionFrame) -> None:
        """Refuse what the viewer would take for something else."""
        if not np.isfinite(frame.timestamp_s):
            raise Refusal(f"timestamp_s is {frame.timestamp_s}, expected finite seconds")
        wanted = None if self._rig.range_m is None else self._rig.range_m.shape
        for name in ("counts", "expected"):
            value = getattr(frame, name)
            if value is not None and np.shape(value) != wanted:
                raise Refusal(f"{name} has shape {np.shape(value)}, expected {wanted} as range_m of the rig")
        for name in ("surface_m", "surface_share"):
            value = getattr(frame, name)
            if value is not None and (np.ndim(value) != 2 or len(value) != len(self._rig.zones)):
                raise Refusal(
                    f"{name} has shape {np.shape(value)}, expected a row for each of {len(self._rig.zones)} zones"
                )

    def flush(self) -> None:
        """Send the histograms that wait, at the end of a session."""
        if self._waiting:
            waiting, self._waiting = self._waiting, []
            send_histograms(self._recording, self._rig, waiting)

    def close(self) -> None:
        """Return once all that was pushed is on its way."""
        self.flush()
        self._recording.flush()

    def _log(self, entity: str, what: Any, static: bool = False) -> None:
        self._recording.log(entity, what, static=static, strict=True)

    def _begin(self) -> None:
        """What holds for all frames; time is that of the frames, not of the logging."""
        self._recording.set_log_time_enabled(False)
        self._recording.set_log_tick_enabled(False)
        log_rig(self._log, self._rig)
        log_charts(self._log, self._rig)
        if self._size is not None:
            log_footprints(self._log, self._rig, self._size)

    def _moved(self, pose: np.ndarray) -> None:
        self._log("world/rig", rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))
        if self._place is not None:
            self._log("world/trajectory", rr.LineStrips3D.from_fields(strips=[[self._place, pose[:3, 3]]]))
        self._place = pose[:3, 3]

    def _pictures(self, frame: SessionFrame, pose: np.ndarray | None) -> None:
        fused = frame.fused
        rgb = frame.rgb if frame.rgb is not None or fused is None else fused.rgb
        intrinsics = frame.intrinsics if frame.intrinsics is not None or fused is None else fused.intrinsics
        size = None if fused is None else fused.depth_m.shape
        if rgb is not None:
            image, size = picture(rgb)
            self._log("world/rig/camera/rgb", image)
        if size is not None and size != self._size:
            self._size = size
            log_footprints(self._log, self._rig, size)
        if size is not None and intrinsics is not None:
            # The viewer counts from the corner of the first pixel, this project from its centre.
            matrix = np.add(intrinsics, [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])
            pinhole = rr.Pinhole(
                image_from_camera=matrix, resolution=size[::-1], image_plane_distance=FRUSTUM_M, color=WHITE
            )
            self._log("world/rig/camera", pinhole)
        if frame.recorded_depth_m is not None:
            self._log("recorded_depth", self._depth("depth", np.asarray(frame.recorded_depth_m)))
        if fused is not None:
            self._log("fused/depth", self._depth("depth", fused.depth_m))
            if np.isfinite(fused.sigma_m).any():
                scale = self._scale("sigma", fused.sigma_m)
                self._log("fused/sigma", metres(fused.sigma_m, SIGMA_PIXELS, "Inferno", scale))
                self._log("fused/confidence", grey(fused.confidence, SIGMA_PIXELS))
        shown = frame.cloud if frame.cloud is not None or fused is None else thin_cloud(fused, self._most)
        if shown is not None:
            self._log("world/cloud", points(shown, self._most, pose, self._by_zone))

    def _depth(self, name: str, depth_m: np.ndarray) -> rr.EncodedDepthImage:
        return metres(depth_m, DEPTH_PIXELS, "Turbo", self._scale(name, depth_m))

    def _scale(self, name: str, values_m: np.ndarray) -> tuple[float, float]:
        """The ends of a colour scale, the same throughout the session."""
        if name not in self._scales:
            known = values_m[np.isfinite(values_m)]
            if not len(known):
                return (0.0, 1.0)
            low, high = (float(q) for q in np.quantile(known, (1 - NEARLY_ALL, NEARLY_ALL)))
            self._scales[name] = (low / HEADROOM if name == "depth" else 0.0, max(HEADROOM * high, 1e-3))
        return self._scales[name]
