"""Where the frames of a RealSense come from: its own pipeline, or the software device of the SDK."""

from typing import Any, Protocol


class Source(Protocol):
    """Frames as the RealSense SDK hands them over, already started."""

    device: Any  # rs.device
    colour: Any  # rs.video_stream_profile
    depth: Any  # the same, or None where there is no depth
    clock_rate: float  # about how many seconds its clock counts in one of the host's: 1, but in a hurried rehearsal

    def drain(self) -> None:
        """Drop the frames that already wait."""

    def wait(self, timeout_s: float) -> Any:
        """The next set of frames, one of each stream; raises `DeviceLost` where none comes in time."""

    def clock_ms(self) -> float | None:
        """What the camera's clock shows now, as in the timestamps of its frames; None where it does not tell."""

    def close(self) -> None:
        """Let go of the device."""
