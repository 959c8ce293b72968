"""What it costs to record a session: a camera frame of 848 x 480, depth, cloud and nine histograms, at 30 Hz."""

import itertools

import numpy as np
import pytest
import rerun as rr

from fusion.cloud import Cloud
from fusion.fused import FusedFrame
from viewers.fusion_session import saved_session
from viewers.session_frame import SessionFrame, SessionRig

HEIGHT, WIDTH, ZONES, BINS = 480, 848, 9, 128
RATE_HZ, SHARE = 30.0, 0.25
FRAMES, ROUNDS = 60, 7
INTRINSICS = np.array([[612.0, 0, 423.5], [0, 612.0, 239.5], [0, 0, 1]])


@pytest.fixture(scope="module")
def frames():
    """Eight frames that differ, as arrays: image with grain, sloping depth with steps, a point for every pixel."""
    made = []
    for k in range(8):
        rng = np.random.default_rng(k)
        v, u = np.mgrid[:HEIGHT, :WIDTH]
        depth = (1.2 + u / WIDTH + 0.5 * (v > 20 * k + 150) + 0.02 * np.sin(u / 30)).astype(np.float32)
        rgb = np.clip(128 + 90 * np.sin(u / 40 + k)[..., None] + rng.normal(0, 6, (HEIGHT, WIDTH, 3)), 0, 255)
        rgb = rgb.astype(np.uint8)
        rays = np.stack([(u - 423.5) / 612, (v - 239.5) / 612, np.ones_like(depth)], axis=-1)
        points = (rays * depth[..., None]).reshape(-1, 3).astype(np.float32)
        ones, zones = np.ones(len(points), np.float32), (u * 9 // WIDTH).astype(np.uint8)
        cloud = Cloud(points, ones, ones, zones.ravel(), rgb.reshape(-1, 3), 0.0)
        counts = rng.poisson(5 + 200 * np.exp(-((np.arange(BINS) - 40) ** 2) / 8), (ZONES, BINS)).astype(np.uint32)
        fused = FusedFrame(0.0, depth, 0.05 * depth, 1 / depth, zones, rgb, INTRINSICS, np.eye(4), "any")
        made.append((fused, cloud, counts))
    return made


def compressed(frames, path):
    """As `difflidar view --save` and a robot do it."""
    rig = SessionRig((3, 3), np.tile(np.arange(BINS) * 0.05, (ZONES, 1)))
    surface = np.tile([1.5, 2.0, np.nan, np.nan], (ZONES, 1))
    with saved_session(path, rig) as push:
        for i, (fused, cloud, counts) in zip(range(FRAMES), itertools.cycle(frames), strict=False):
            push(SessionFrame(i / RATE_HZ, counts, surface, surface / 4, fused, cloud))


def as_it_is(frames, path):
    """The same by the library's own examples: each thing logged, whole and as it is, in every frame."""
    with rr.RecordingStream("bench") as recording:
        recording.save(path)
        for i, (fused, cloud, counts) in zip(range(FRAMES), itertools.cycle(frames), strict=False):
            recording.set_time("time", duration=i / RATE_HZ)
            recording.log("camera", rr.Transform3D(translation=fused.pose[:3, 3], mat3x3=fused.pose[:3, :3]))
            recording.log("camera/rgb", rr.Image(fused.rgb))
            recording.log("camera/depth", rr.DepthImage(fused.depth_m, meter=1.0))
            recording.log("sigma", rr.DepthImage(fused.sigma_m, meter=1.0))
            recording.log("cloud", rr.Points3D(cloud.points_m, colors=cloud.colours))
            for zone, values in enumerate(counts):
                recording.log(f"zone/{zone}", rr.BarChart(values))
        recording.flush()
        recording.disconnect()


@pytest.mark.benchmark(group=f"session of {FRAMES} frames 848 x 480 with depth, cloud and histograms")
@pytest.mark.parametrize("how", [compressed, as_it_is])
def test_session(benchmark, frames, tmp_path, how):
    path = tmp_path / "session.rrd"
    benchmark.pedantic(how, (frames, path), rounds=ROUNDS, warmup_rounds=1)
    each_ms = 1e3 * benchmark.stats.stats.median / FRAMES
    benchmark.extra_info["ms a frame"] = each_ms
    share = each_ms * RATE_HZ / 1e3
    print(f"\n{how.__name__}: {each_ms:.2f} ms a frame, {share:.0%} of a 30 Hz frame (aim {SHARE:.0%}); ", end="")
    print(f"{path.stat().st_size / FRAMES / 1e3:.0f} kB a frame")
