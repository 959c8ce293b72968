import numpy as np
import pytest

from mismatch.calibrations.catalogue import catalogue
from mismatch.calibrations.departure import Departure
from mismatch.calibrations.pair import pair
from physics.effects import all_effects
from recordings.maps import ResponseMaps

EVERY = catalogue()


@pytest.fixture(scope="module")
def two():
    xs, ys = (g.ravel() for g in np.meshgrid(np.arange(30) * 20.0 + 100, np.arange(20) * 20.0 + 50))
    blob = np.exp(-((xs - 300) ** 2 + (ys - 200) ** 2) / 2e4)
    values = (1e5 * np.stack([blob, blob[::-1]]) + 50).reshape(1, 2, -1)
    maps = ResponseMaps(values, xs, ys, np.array([f"{i:04d}" for i in range(len(xs))]))
    return pair(maps, maps)


@pytest.mark.parametrize("departure", EVERY, ids=lambda d: d.name)
def test_it_vanishes_at_zero_and_not_elsewhere(two, departure: Departure):
    zones = len(two.a)
    strong = departure.strength_count(zones)
    x = np.concatenate([np.zeros(strong), departure.tries(two)[0]])
    assert departure.apply(two, two.a, x) == pytest.approx(two.a, rel=1e-9, abs=1e-6)
    x[:strong] = departure.scales(zones)[:strong]
    changed = departure.apply(two, two.a, x)
    assert changed.shape == two.a.shape
    assert (changed >= 0).all()
    assert np.abs(changed - two.a).max() > 1e-4 * two.a.max()


@pytest.mark.parametrize("departure", EVERY, ids=lambda d: d.name)
def test_it_is_of_the_vocabulary(departure: Departure):
    known = set(all_effects())
    assert departure.id in known
    assert {look.id for look in departure.look_alikes} <= known
    assert len(departure.labels(4)) == departure.count(4) == len(departure.scales(4))


def test_tiles_are_held_out_whole(two):
    for tile in np.unique(two.tile):
        assert len(set(two.held[two.tile == tile])) == 1
    assert 0.35 < two.held.mean() < 0.65
