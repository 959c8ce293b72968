"""Frames as a robot gets them: one in, one cloud out, whatever the frame is like."""

import threading

import numpy as np

from fusion.cloud import Cloud, cloud, no_points, zone_cloud
from fusion.depths import zone_depths
from fusion.fuse import METHODS, expect_method, fuse_frame
from fusion.motion import Earlier
from fusion.odometry import Odometry
from fusion.range_response import RangeResponse
from fusion.sight import Sight
from fusion.volume import Volume
from fusion.zone_view import DEAD, GOOD, SATURATED, ZoneDepths
from recordings.refusal import Refusal

# So many frames in a row before the last one: the clock was set anew.
CLOCK_FRAMES = 10
# Kinds of complaints that are kept apart; later ones are counted together.
MOST_COMPLAINTS = 1000
OTHERS = "further complaints, of more kinds than are kept apart"


class Fuser:
    """Histograms and images to clouds, frame by frame, in constant time and bounded memory.

    sight, response: of the rig, as `fusion.rig.rig_of` makes them. method: one of `fusion.fuse.METHODS`.
    volume: where frames with a pose are added up; none where None. odometry: whether poses that are not given are found
    from colour and depth.

    complaints: sentence -> how many frames it was about. frames: how many came, skipped: how many of them gave no cloud
    because of a complaint. latest: the last cloud that has points. All of it may be used from several threads: frames
    are taken one at a time.
    """

    def __init__(
        self,
        sight: Sight,
        response: RangeResponse,
        method: str = METHODS[-1],
        *,
        volume: Volume | None = None,
        odometry: bool = False,
    ) -> None:
        expect_method(method)
        if sight.zones != response.counts.shape[0]:
            raise Refusal(f"the maps have {sight.zones} zones, expected {response.counts.shape[0]} as the sensor has")
        self.sight, self.response, self.method, self.volume = sight, response, method, volume
        self.complaints: dict[str, int] = {}
        self.frames = self.skipped = 0
        self.latest: Cloud | None = None
        self._odometry = Odometry() if odometry else None
        self._earlier = Earlier(sight)
        self._last_s, self._early = -np.inf, 0
        self._one_at_a_time = threading.Lock()

    def push(
        self,
        counts: np.ndarray,
        rgb: np.ndarray | bytes | None = None,
        pose: np.ndarray | None = None,
        timestamp_s: float | None = None,
    ) -> Cloud:
        """The cloud of a frame: in the world where a pose is known, else in the camera's frame.

        counts: (P, T). rgb: (H, W, 3) uint8, or PNG or JPEG bytes, None where the camera gave none: then the cloud is a
        point for each surface in the direction of its zone. pose: (4, 4) world from camera. timestamp_s: seconds, that
        of the last frame where None. A frame that cannot be used gives a cloud without points and a complaint; it
        raises nothing.
        """
        with self._one_at_a_time:
            self.frames += 1
            try:
                made = self._made(counts, rgb, pose, timestamp_s)
            except Refusal as wrong:
                self._complain(str(wrong))
                self.skipped += 1
                return no_points(max(self._last_s, 0.0))
            if len(made):
                self.latest = made
            return made

    def _made(self, counts, rgb, pose, timestamp_s) -> Cloud:
        """The cloud of a frame; `Refusal` where there can be none."""
        counts = self._counts(counts)
        at_s = self._time(timestamp_s)
        depths = zone_depths(counts, self.response)
        for state, word in ((DEAD, "dead"), (SATURATED, "saturated")):
            for zone in np.flatnonzero(depths.state == state):
                self._complain(f"zone {zone} is {word}: it counts for nothing")
        if not (depths.state == GOOD).any():
            raise Refusal("all zones are dead or saturated, expected one that can be used")
        pose = self._pose(pose)
        if rgb is not None:
            made = self._with_image(counts, rgb, pose, at_s, depths)
            if made is not None:
                return made
        elif self._odometry is not None:
            self._complain("rgb is missing: the cloud is by direction of zones, and no pose can be found")
        else:
            self._complain("rgb is missing: the cloud is by direction of zones")
        bare = zone_cloud(self.sight, depths, at_s)
        return bare if pose is None else bare.in_world(pose)

    def _with_image(self, counts, rgb, pose: np.ndarray | None, at_s: float, depths: ZoneDepths) -> Cloud | None:
        """The cloud on the camera's pixels, None where the image is of no use."""
        motion = self._earlier.motion(pose, depths.typical_m)
        more = {"timestamp_s": at_s, "pose": pose, "depths": depths, "motion": motion}
        try:
            fused = fuse_frame(counts, rgb, self.sight, self.response, self.method, **more)
        except Refusal as wrong:
            self._complain(f"{wrong}: the cloud is by direction of zones")
            return None
        self._earlier.add(fused.rgb, pose, depths.typical_m)
        if pose is None and self._odometry is not None and fused.known.any():
            pose = self._odometry.push(fused)
            if pose is None:
                self._complain("odometry finds no motion: the frame has no pose until it sees again what it saw last")
        if self.volume is not None and pose is not None:
            try:
                self.volume.add(fused, pose)
            except Refusal:  # It names numbers of the frame, and there may be many.
                self._complain("a frame needs more blocks than the volume has room for: it was not added")
        made = cloud(fused)
        return made if pose is None else made.in_world(pose)

    def _counts(self, counts) -> np.ndarray:
        """(P, T) counts; refused, in words that are the same every time, where they are none."""
        shape = self.response.counts.shape[0], self.response.sensor.bins
        try:
            found = np.asarray(counts)
        except (TypeError, ValueError):
            found = np.empty(0)
        if found.shape != shape or found.dtype.kind not in "uif":
            raise Refusal(f"counts are no numbers of shape {shape}, expected such: the frame is skipped")
        if not (np.isfinite(found).all() and (found >= 0).all()):
            raise Refusal("counts hold NaN, infinity or values below 0: the frame is skipped")
        return found

    def _time(self, timestamp_s: float | None) -> float:
        """Seconds; refused where they do not come after those of the last frame, unless the clock was set anew."""
        if timestamp_s is None:
            return max(self._last_s, 0.0)
        try:
            at_s = float(timestamp_s)
        except (TypeError, ValueError):
            at_s = np.nan
        if not np.isfinite(at_s):
            raise Refusal("timestamp_s is no finite number: the frame is skipped")
        if at_s <= self._last_s:
            self._early += 1
            if self._early < CLOCK_FRAMES:
                raise Refusal("timestamp_s is not after that of the last frame: the frame is skipped")
            self._complain(f"timestamp_s went back for {CLOCK_FRAMES} frames: the clock is taken to have been set anew")
        self._last_s, self._early = at_s, 0
        return at_s

    def _pose(self, pose) -> np.ndarray | None:
        """(4, 4) pose, None where it is none that can be."""
        if pose is None:
            return None
        try:
            found = np.asarray(pose, float)
        except (TypeError, ValueError):
            found = np.empty(0)
        turn = found[:3, :3] if found.shape == (4, 4) else np.full((3, 3), np.nan)
        rigid = np.isfinite(found).all() and np.allclose(turn @ turn.T, np.eye(3), atol=1e-3)
        if rigid and np.linalg.det(turn) > 0 and np.allclose(found[3], (0, 0, 0, 1)):
            return found
        self._complain("pose is no rigid (4, 4) transform: the frame is taken to have none")
        return None

    def _complain(self, sentence: str) -> None:
        """Count a complaint."""
        if sentence not in self.complaints and len(self.complaints) >= MOST_COMPLAINTS:
            sentence = OTHERS
        self.complaints[sentence] = self.complaints.get(sentence, 0) + 1
