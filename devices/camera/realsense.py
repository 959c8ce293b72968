"""A RealSense: depth aligned with colour, frames exposed after they were asked for."""

import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pyrealsense2 as rs

from calibrate.rig import CameraSetup
from devices.camera.described import described
from devices.camera.settings import temperature_c
from devices.camera.source import Source
from devices.captures import DeviceLost, Picture
from devices.clock import unwrapped

# Where the camera does not tell its time: frames under way when one is asked for (exposed, read out, matched).
IN_FLIGHT = 3
TEMPERATURE_EVERY_S = 5.0  # asking for it takes the camera's time
MOST_WAITED = 60  # frames; a camera whose clock and frames disagree is not waited for without end
CLOCK_PERIOD_MS = 2**32 * 1e-3  # the D400 counts microseconds in 32 bits, so its clock starts anew every 71.6 minutes
END, MIDDLE = rs.frame_metadata_value.frame_timestamp, rs.frame_metadata_value.sensor_timestamp  # of the exposure
KEPT = ("actual_exposure", "gain_level", "auto_exposure", "white_balance", "temperature", "frame_laser_power")
KEPT_OF_DEPTH = (*KEPT, "frame_emitter_mode", "frame_laser_power_mode")


class RealSense:
    """A camera of the D400 series, or one that the SDK's software device stands in for; satisfies `Camera`.

    said: see `described`. tally: pictures, discarded (frames that were under way when one was asked for), lost and
    repeated (by the camera's frame numbers, while frames were waited for).
    """

    def __init__(self, source: Source, setup: CameraSetup, timeout_s: float = 5.0) -> None:
        self._source = source
        self._timeout_s = timeout_s
        self._align = rs.align(rs.stream.color)
        self._last: tuple[float, float] | None = None  # device and host time of the last picture, ms and s
        self._felt: tuple[float, float | None] = (-TEMPERATURE_EVERY_S, None)
        self._closed = False
        self.said = described(source, setup)
        self.tally = {"pictures": 0, "discarded": 0, "lost": 0, "repeated": 0}

    def capture(self) -> Picture:
        """A frame all of whose streams began their exposure after the call; raises `DeviceLost`."""
        before = time.time()
        asked_ms = self._source.clock_ms()
        after = time.time()
        self._source.drain()
        first = previous = None
        for _ in range(MOST_WAITED):
            frames = self._source.wait(self._timeout_s)
            arrived = time.time()
            numbers = [frame.get_frame_number() for frame in frames]
            self._count(previous, numbers)
            first, previous = first or numbers, numbers
            told = asked_ms is not None and all(tells_exposure(frame) for frame in frames)
            if told:
                fresh = all(_later(exposed_ms(frame)[0], asked_ms) for frame in frames)
            else:
                fresh = all(now - then >= IN_FLIGHT for now, then in zip(numbers, first, strict=True))
            if fresh:
                picture = self._picture(frames, arrived)
                if told:
                    read_s = self._unwrapped(asked_ms, after) / 1e3
                    picture.said["clock_read"] = [before, read_s, after]
                return picture
            self.tally["discarded"] += 1
        raise DeviceLost(f"the RealSense sent {MOST_WAITED} frames, none of them exposed after it was asked for one")

    def frames(self) -> Iterator[Picture]:
        """Every frame as it comes, until the camera is closed; raises `DeviceLost`."""
        previous = None
        while not self._closed:
            frames = self._source.wait(self._timeout_s)
            arrived = time.time()
            numbers = [frame.get_frame_number() for frame in frames]
            self._count(previous, numbers)
            previous = numbers
            yield self._picture(frames, arrived)

    def close(self) -> None:
        """Stop the streams."""
        if not self._closed:
            self._closed = True
            self._source.close()

    def _count(self, previous: list[int] | None, numbers: list[int]) -> None:
        steps = [now - then for now, then in zip(numbers, previous or [n - 1 for n in numbers], strict=True)]
        self.tally["lost"] += max(max(steps) - 1, 0)
        self.tally["repeated"] += sum(step == 0 for step in steps)

    def _picture(self, frames: Any, arrived: float) -> Picture:
        has_depth = self._source.depth is not None
        aligned = self._align.process(frames) if has_depth else frames
        colour = aligned.get_color_frame()
        depth = aligned.get_depth_frame() if has_depth else None
        start, middle = exposed_ms(colour)
        if abs(arrived - self._felt[0]) >= TEMPERATURE_EVERY_S:
            self._felt = arrived, temperature_c(self._source.device)
        device_ms = self._unwrapped(middle, arrived)
        self._last = device_ms, arrived
        self.tally["pictures"] += 1
        said = {
            "clock": colour.get_frame_timestamp_domain().name,
            "exposed_s": 2 * (middle - start) / 1e3,
            "temperature_c": self._felt[1],
            "colour": metadata(colour, KEPT),
            **({"depth": metadata(depth, KEPT_OF_DEPTH), "depth_number": depth.get_frame_number()} if depth else {}),
            **self.tally,
        }
        return Picture(
            rgb=np.array(colour.get_data()),  # a copy: the SDK takes its buffer back
            depth_m=metres(np.asanyarray(depth.get_data()), depth.get_units()) if depth else None,
            device_s=device_ms / 1e3,
            host_s=arrived,
            number=colour.get_frame_number(),
            said=said,
        )

    def _unwrapped(self, ms: float, host_s: float) -> float:
        if self._last is None:
            return ms
        last_ms, last_host = self._last
        return unwrapped(ms, CLOCK_PERIOD_MS, last_ms + (host_s - last_host) * 1e3 * self._source.clock_rate)


def tells_exposure(frame: Any) -> bool:
    """Whether a frame tells its exposure by the camera's clock; none does where the kernel passes no metadata."""
    by_camera = frame.get_frame_timestamp_domain() == rs.timestamp_domain.hardware_clock
    return by_camera and frame.supports_frame_metadata(END) and frame.supports_frame_metadata(MIDDLE)


def exposed_ms(frame: Any) -> tuple[float, float]:
    """When a frame's exposure began and its middle, by the clock of its timestamps, ms.

    The D400 stamps a frame when its exposure ends and readout begins, and tells the middle of the exposure besides
    (`md_rs400_sensor_timestamp` in the SDK's metadata parsers). Without that, both are the frame's timestamp.
    """
    if tells_exposure(frame):
        end_us, middle_us = frame.get_frame_metadata(END), frame.get_frame_metadata(MIDDLE)
        return (2 * middle_us - end_us) / 1e3, middle_us / 1e3
    return frame.get_timestamp(), frame.get_timestamp()


def metadata(frame: Any, names: tuple[str, ...]) -> dict[str, float]:
    """Frame number, timestamp in ms, and those of the named values that the camera sent along."""
    said = {"number": frame.get_frame_number(), "timestamp_ms": frame.get_timestamp()}
    for name in names:
        value = getattr(rs.frame_metadata_value, name)
        if frame.supports_frame_metadata(value):
            said[name] = frame.get_frame_metadata(value)
    return said


def metres(units: np.ndarray, metres_each: float) -> np.ndarray:
    """(H, W) uint16 of the depth sensor, 0 where unknown, as float32 metres, NaN where unknown."""
    depth = units.astype(np.float32)
    depth *= np.float32(metres_each)
    depth[units == 0] = np.nan
    return depth


def _later(ms: float, than_ms: float) -> bool:
    """Whether a reading of the wrapping clock is at or after another, at most half a period away."""
    return (ms - than_ms) % CLOCK_PERIOD_MS < CLOCK_PERIOD_MS / 2
