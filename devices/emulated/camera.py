"""A RealSense that is not there: the SDK's software device, shown what a function sees."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import pyrealsense2 as rs

from calibrate.rig import CameraSetup
from devices.camera.settings import set_up
from devices.captures import DeviceLost
from devices.emulated.pictures import Look, PictureClient, counts
from devices.emulated.software_device import OF_COLOUR, OF_DEPTH, UNIT_M, add_options, add_stream, lens_of, wider
from recordings.refusal import Refusal

CLOCK_PERIOD_US = 2**32  # the clock of the D400 has 32 bits of microseconds


class SoftwareRealSense:
    """Frames of the SDK's software device; see `Source`.

    look: () -> rgb (H, W, 3) uint8 and depth (H, W), metres (NaN where unknown) or uint16 of UNIT_M; asked once a
    frame, and a frame is exposed for as long as the look takes. intrinsics: fx, fy, cx, cy of both streams, pixels.
    with_depth: False where look gives None. shift_m: x of the depth sensor in the colour sensor's frame. speed: its
    clock's seconds to one of the host's, times 1 + skew. clock_s: what its clock shows at first. close: called in the
    end.
    """

    def __init__(
        self,
        look: Look,
        setup: CameraSetup,
        *,
        intrinsics: tuple[float, ...] = (),
        with_depth: bool = True,
        shift_m: float = 0.0,
        speed: float = 1.0,
        skew: float = 0.0,
        clock_s: float = 0.0,
        close: Callable[[], None] = lambda: None,
    ) -> None:
        self._look, self._close = look, close
        self.clock_rate = speed
        self._fps, self._rate, self._start_s = setup.fps, speed * (1 + skew), clock_s
        self._since = time.monotonic()
        self._number = 0
        self._size = tuple(setup.size)
        lens = lens_of(self._size, intrinsics)
        self.device = rs.software_device()
        self.device.register_info(rs.camera_info.name, "Rehearsed RealSense")
        self.device.register_info(rs.camera_info.serial_number, "rehearsed")
        self._sensors = [self.device.add_sensor("RGB Camera")]
        self.colour = add_stream(self._sensors[0], rs.stream.color, rs.format.rgb8, 3, lens, setup.fps)
        self.depth = None
        add_options(self._sensors[0], OF_COLOUR)
        if with_depth:
            stereo = self.device.add_sensor("Stereo Module")
            self._sensors.append(stereo)
            self.depth = add_stream(stereo, rs.stream.depth, rs.format.z16, 2, wider(lens), setup.fps)
            stereo.add_read_only_option(rs.option.depth_units, UNIT_M)
            add_options(stereo, OF_DEPTH)
            to_colour = rs.extrinsics()
            to_colour.rotation, to_colour.translation = np.eye(3).ravel().tolist(), [shift_m, 0.0, 0.0]
            self.depth.register_extrinsics_to(self.colour, to_colour)
        self._profiles = [p for p in (self.colour, self.depth) if p is not None]
        set_up(self.device, setup)
        # The SDK's own matcher waits for the frames of a regular camera; here they come when they are asked for.
        self._queues = [rs.frame_queue(1) for _ in self._sensors]
        self._set: list[Any] = []
        self._matched = rs.frame_queue(1)
        self._matcher = rs.processing_block(lambda _, to: to.frame_ready(to.allocate_composite_frame(self._set)))
        self._matcher.start(self._matched)
        for sensor, profile, queue in zip(self._sensors, self._profiles, self._queues, strict=True):
            sensor.open(profile)
            sensor.start(queue)

    def drain(self) -> None:
        """Nothing waits: a frame is made when it is waited for."""

    def wait(self, timeout_s: float) -> Any:
        """Look, show the device what was seen, hand over the set of frames that it makes."""
        begin_us = self._now_us()
        rgb, depth = self._look()
        # Numbers go up by one a period, and by one at least.
        self._number = max(self._number + 1, int(begin_us * 1e-6 * self._fps))
        end_us = max(self._now_us(), begin_us + 2)
        shape = self._size[::-1]
        planes = [
            _plane(rgb, np.uint8, (*shape, 3)),
            *([] if self.depth is None else [_plane(counts(depth), np.uint16, shape)]),
        ]
        for plane, sensor, profile in zip(planes, self._sensors, self._profiles, strict=True):
            self._show(plane, sensor, profile, begin_us, end_us)
        timeout_ms = int(timeout_s * 1e3)
        try:
            self._set[:] = [queue.wait_for_frame(timeout_ms) for queue in self._queues]
            self._matcher.invoke(self._set[0])
            return self._matched.wait_for_frame(timeout_ms).as_frameset()
        except RuntimeError as wrong:
            raise DeviceLost(f"the rehearsed camera stopped: {wrong}") from None
        finally:
            self._set.clear()

    def clock_ms(self) -> float | None:
        """The camera's clock now."""
        return self._now_us() % CLOCK_PERIOD_US / 1e3

    def close(self) -> None:
        """Stop the streams and whoever looks."""
        for sensor in self._sensors:
            sensor.stop()
            sensor.close()
        self._close()

    def _now_us(self) -> int:
        return int((self._start_s + (time.monotonic() - self._since) * self._rate) * 1e6)

    def _show(self, plane: np.ndarray, sensor: Any, profile: Any, begin_us: int, end_us: int) -> None:
        end_wrapped = end_us % CLOCK_PERIOD_US
        sensor.set_metadata(rs.frame_metadata_value.frame_timestamp, end_wrapped)
        sensor.set_metadata(rs.frame_metadata_value.sensor_timestamp, end_wrapped - (end_us - begin_us) // 2)
        if sensor is not self._sensors[0]:
            emitter = int(sensor.get_option(rs.option.emitter_enabled))
            sensor.set_metadata(rs.frame_metadata_value.frame_emitter_mode, emitter)
        frame = rs.software_video_frame()
        frame.pixels = plane
        frame.bpp = plane.dtype.itemsize * (plane.shape[2] if plane.ndim == 3 else 1)
        frame.stride = plane.shape[1] * frame.bpp
        frame.timestamp = end_wrapped / 1e3
        frame.domain = rs.timestamp_domain.hardware_clock
        frame.frame_number = self._number
        frame.profile = profile
        frame.depth_units = UNIT_M
        sensor.on_video_frame(frame)


def open_rehearsed(setup: CameraSetup, timeout_s: float = 5.0) -> SoftwareRealSense:
    """The camera of the rehearsal that listens at the socket `setup.device`; `Refusal` where none does."""
    client = PictureClient(setup.device, timeout_s)
    said = client.said
    if list(said["size"]) != list(setup.size):
        client.close()
        raise Refusal(f"the rehearsal's camera has {said['size']} pixels, expected camera.size {list(setup.size)}")
    try:
        return SoftwareRealSense(
            client.look,
            setup,
            intrinsics=tuple(said["intrinsics"]),
            with_depth=said["depth"],
            speed=said["speed"],
            close=client.close,
        )
    except BaseException:
        client.close()
        raise


def _plane(seen: np.ndarray | None, kind: type, shape: tuple[int, ...]) -> np.ndarray:
    # The SDK takes the memory as it is, so nothing of another size may get there.
    plane = np.ascontiguousarray(seen, kind)
    if plane.shape != shape:
        raise DeviceLost(f"the scene gave a picture of shape {plane.shape}, expected {shape}")
    return plane
