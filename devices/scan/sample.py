"""What was seen at a position, as the journal keeps it."""

import cv2
import numpy as np

from devices.captures import Measurement, Picture, Settled
from devices.scan.journal import Frame, Journal, Sample
from recordings.refusal import Refusal

# Sharp enough to place the patch to a few hundredths of a pixel; a frame takes a tenth of what PNG takes.
JPEG_QUALITY = 92


def sample_of(name: str, cell: int, settled: Settled, seen: list[tuple[Measurement, Picture | None]]) -> Sample:
    """A sample without its pictures, which are encoded later."""
    measured = [measurement for measurement, _ in seen]
    said = {
        "pose": settled.pose.round(6).tolist(),
        "joints": settled.joints.round(6).tolist(),
        "temperature_c": [m.temperature_c for m in measured],
        "number": [m.number for m in measured],
        "device_s": [m.device_s for m in measured],
        "reference_counts": [int(m.reference.sum()) for m in measured],
        "distance_mm": [None if m.distance_mm is None else m.distance_mm.tolist() for m in measured],
        "camera": [
            None if p is None else p.said | {"device_s": p.device_s, "host_s": p.host_s, "number": p.number}
            for _, p in seen
        ],
    }
    return Sample(name, cell, tuple(Frame(m.host_s, m.counts, None) for m in measured), said)


def keep(journal: Journal, sample: Sample, pictures: list[np.ndarray | None]) -> None:
    """Encode the pictures, and write."""
    frames = tuple(
        Frame(frame.time_s, frame.counts, None if rgb is None else _jpeg(rgb))
        for frame, rgb in zip(sample.frames, pictures, strict=True)
    )
    journal.add(Sample(sample.pass_name, sample.cell, frames, sample.said))


def _jpeg(rgb: np.ndarray) -> bytes:
    done, data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    if not done:
        raise Refusal(f"a picture of shape {rgb.shape} cannot be written as JPEG")
    return data.tobytes()
