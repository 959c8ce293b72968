"""The offset of two clocks over a scan, with one that was put in."""

import numpy as np

from devices.scan.clocks import clocks_apart
from devices.scan.journal import Frame, Journal, Sample


def journal(tmp_path, count, seed=0):
    """The LiDAR's clock runs 1 % fast and stands at 50 s when the camera's stands at 7 s."""
    kept, rng = Journal(tmp_path / "s.scanning"), np.random.default_rng(seed)
    for i in range(count):
        now = 0.4 * i
        picture = {"device_s": 7 + now, "host_s": 1e9 + now + 0.004 + rng.exponential(1e-3)}
        arrived = 1e9 + now + 0.002 + rng.exponential(1e-3)
        said = {"device_s": [50 + 1.01 * now], "camera": [picture]}
        kept.add(Sample("patch", i, (Frame(arrived, np.ones((2, 3), np.uint32), None),), said))
    return kept, 0.4 * (count - 1)


def test_the_offset_that_was_put_in_comes_out(tmp_path):
    kept, last = journal(tmp_path, 200)
    found = clocks_apart(kept)
    # Arrivals cannot tell that the camera's least latency is 2 ms longer.
    truth = (7 + last) - (50 + 1.01 * last) - 0.004 + 0.002 * 1.01
    assert abs(found["offset_s"] - truth) < 5 * found["sigma_s"] + 0.01 * 0.01
    assert found["sigma_s"] < 1e-3
    assert found["systematic_s"] is None
    assert abs(found["lidar_skew"] + 0.01 / 1.01) < 1e-4


def test_too_few_messages_tell_nothing(tmp_path):
    assert clocks_apart(journal(tmp_path, 3)[0]) is None
