"""Where in each frame a pulse is that may be anywhere: compiled sums over bins that hold counts, beside numpy's."""

import time

import numpy as np

from physics.clock import Clock
from physics.pulse import tailed_pulse
from physics.roaming import pulses_in_bins, roaming

FRAMES, ZONES, BINS, WIDTH_S = 72, 4, 128, 1e-10
COUNTS, PRESENT = np.full(ZONES, 30.0), 0.8


def by_numpy(recorded, mean, shares):
    """(F,) twice the log-evidence of frames, all places and bins of a frame at once."""
    found = []
    for seen, expected in zip(recorded, mean, strict=True):
        more = COUNTS[:, None, None] * shares
        ratio = (seen[:, None] * np.log1p(more / expected[:, None]) - more).sum(axis=(0, 2))
        found.append(np.log(1 - PRESENT + PRESENT * np.exp(ratio).mean()))
    return 2 * np.array(found)


def test_roaming():
    """A long tail, as an estimated response has: half of the bins hold some of each pulse. No counts twice."""
    clock = Clock(WIDTH_S, BINS, np.zeros(1), tailed_pulse(2e-10, 3e-10, 2e-9, 0.2, step_s=WIDTH_S / 8))
    shares, rng, taken, found = pulses_in_bins(clock.pulse, BINS, WIDTH_S), np.random.default_rng(1), {}, {}
    for _ in range(5):
        mean = rng.uniform(2, 8, (FRAMES, ZONES, BINS))
        recorded = rng.poisson(mean).astype(float)
        ways = {
            # All of it is background: no frame is brighter than another.
            "roaming": lambda n=recorded, m=mean: roaming(n, m, m, clock, COUNTS, PRESENT).evidence,
            "numpy": lambda n=recorded, m=mean: by_numpy(n, m, shares),
        }
        for name, way in ways.items():
            begin = time.perf_counter()
            found[name] = way()
            taken.setdefault(name, []).append(time.perf_counter() - begin)
    mine, theirs = (np.median(taken[name][1:]) for name in ("roaming", "numpy"))
    print(f"\nroaming {1e3 * mine:.0f} ms, numpy {1e3 * theirs:.0f} ms, {theirs / mine:.1f} times")
    # Shares of less than 1e-5 are left out by the one alone.
    np.testing.assert_allclose(found["roaming"], found["numpy"], atol=0.05)
    assert mine < theirs
