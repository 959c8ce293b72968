"""A scan recording of 3600 frames: how fast it opens and is run through, and how much memory that takes."""

import subprocess
import sys

import cv2
import numpy as np
import pytest

from recordings.files import save
from recordings.stream import Stream

FRAMES = 3600
LIMIT_MB = 1024
# The high-water mark of this program alone: getrusage would count the parent it was forked from, too.
ITERATE = """
import sys
from recordings.files import load
recording = load(sys.argv[1])
total = sum(int(image[0, 0, 0]) for image in recording.rgb) + int(recording.counts.sum())
print(int(open("/proc/self/status").read().split("VmHWM:")[1].split()[0]) / 1024)
"""


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    rng = np.random.default_rng(0)
    pictures = [
        cv2.imencode(".jpg", cv2.GaussianBlur(rng.integers(0, 255, (480, 848, 3), np.uint8), (0, 0), 2))[1].tobytes()
        for _ in range(16)
    ]
    frames = (
        {"counts": rng.poisson(50, (9, 128)).astype(np.uint32), "timestamp_s": float(k), "rgb": pictures[k % 16]}
        for k in range(FRAMES)
    )
    static = {
        "zone_grid": np.array([3, 3]),
        "bin_width_s": np.float64(0.38e-9),
        "time_zero_s": np.float64(5e-9),
        "image_size": np.array([848, 480]),
        "meta_json": "{}",
    }
    path = tmp_path_factory.mktemp("scan") / "scan.rrd"
    save(Stream(static=static, frames=frames, count=FRAMES), path)
    return path


def open_and_iterate(path):
    done = subprocess.run([sys.executable, "-c", ITERATE, path], capture_output=True, text=True, check=True)
    return float(done.stdout)


@pytest.mark.benchmark(group="3600 frames with JPEG 848 x 480, opened and run through in a process of its own")
def test_memory(benchmark, scan):
    peak_mb = benchmark.pedantic(open_and_iterate, (scan,), rounds=3)
    benchmark.extra_info["peak resident MB"] = round(peak_mb)
    print(f"\npeak resident memory {peak_mb:.0f} MB, limit {LIMIT_MB} MB")
    assert peak_mb < LIMIT_MB
