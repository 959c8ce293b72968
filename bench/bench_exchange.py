"""Light that patches of one frame exchange: pair by pair, beside numpy's sums over all pairs at once."""

import time

import numpy as np
import pytest

from physics.exchange import exchange
from tests.physics.test_exchange import by_pairs, scene

PATCHES, ZONES, KNOTS = 780, 9, 1024


@pytest.mark.parametrize("rough", [False, True])
def test_exchange(rough):
    """As many patches as a frame of 106 x 60 pixels has, and knots as 128 bins in eight steps each."""
    arrays, taken, found = scene(3, PATCHES, ZONES), {}, {}

    def ours(*asked):
        out = np.zeros((ZONES, KNOTS))
        exchange(*asked[:-1], out)
        return out

    for _ in range(4):
        for name, way in (("exchange", ours), ("numpy", by_pairs)):
            begin = time.perf_counter()
            found[name] = way(*arrays, rough, 120.0, 2.0, KNOTS)
            taken.setdefault(name, []).append(time.perf_counter() - begin)
    mine, theirs = (np.median(taken[name][1:]) for name in ("exchange", "numpy"))
    print(f"\nrough {rough}: exchange {1e3 * mine:.1f} ms, numpy {1e3 * theirs:.0f} ms, {theirs / mine:.0f} times")
    np.testing.assert_allclose(found["exchange"], found["numpy"], rtol=1e-9, atol=1e-12)
    assert mine < theirs
