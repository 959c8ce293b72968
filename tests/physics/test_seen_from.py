"""Light that is put in slots is neither lost nor made."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from physics.seen_from import put


@given(seed=st.integers(0, 10_000), many=st.integers(1, 6))
def test_what_is_put_in_slots_is_all_there(seed, many):
    rng = np.random.default_rng(seed)
    strength = np.where(rng.random((many, 3, 4)) < 0.4, rng.random((many, 3, 4)), 0)
    ranges = rng.uniform(0.2, 3, strength.shape)
    slot_ranges, slots = np.ones((3, 3, 4)), np.zeros((3, 3, 4))
    for r, s in zip(ranges, strength, strict=True):
        put(r, s, slot_ranges, slots)
    np.testing.assert_allclose(slots.sum(axis=0), strength.sum(axis=0), atol=1e-12)
    np.testing.assert_allclose((slots * slot_ranges).sum(axis=0), (strength * ranges).sum(axis=0), atol=1e-12)
    # Where there are no more than slots each is by itself.
    few = (strength > 0).sum(axis=0) <= 3
    every = np.concatenate([strength, np.zeros((3, 3, 4))])
    np.testing.assert_allclose(np.sort(slots, axis=0)[:, few], np.sort(every, axis=0)[-3:, few])
