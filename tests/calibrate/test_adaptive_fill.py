import importlib.util
from pathlib import Path

import numpy as np
import pytest

from calibrate.adaptive_fill import filled
from calibrate.consistency import cosines
from calibrate.flags import Flag
from calibrate.sparse import spread_order
from recordings.refusal import Refusal

# Tests are no package: the helper beside this file is loaded by its place.
_spec = importlib.util.spec_from_file_location("adaptive_sensor", Path(__file__).with_name("adaptive_sensor.py"))
adaptive_sensor = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(adaptive_sensor)
part_of, sensor, RADIUS_PX = adaptive_sensor.part_of, adaptive_sensor.sensor, adaptive_sensor.RADIUS_PX


@pytest.mark.slow
def test_what_was_not_visited_is_predicted_within_its_error():
    maps = sensor(21)
    field = np.stack([maps.xs, maps.ys], axis=1).astype(float)
    lit = np.flatnonzero((maps.normalised > 0.02).any(axis=0))
    cells = np.sort(np.concatenate([lit[spread_order(field[lit], 130)], spread_order(field, 20)]))
    cells = np.unique(cells)
    found = filled(part_of(maps, cells), field, RADIUS_PX)
    assert len(found.xs) == len(maps.xs)
    assert np.array_equal(found.responses[..., : len(cells)], maps.responses[..., cells])
    assert np.array_equal(found.cap_ids[: len(cells)], maps.cap_ids[cells])
    measured = np.zeros(found.flags.shape, bool)
    measured[..., : len(cells)] = True
    assert np.array_equal(found.flags & Flag.PREDICTED > 0, ~measured)
    assert found.meta["predicted"] == len(maps.xs) - len(cells)
    rest = np.array([int(name[1:]) for name in found.cap_ids[len(cells) :]])
    assert sorted([*rest, *cells]) == list(range(len(maps.xs)))
    full = maps.by_zone.astype(float)[:, rest]
    value, sigma = found.by_zone[:, len(cells) :], found.sigma.reshape(9, -1)[:, len(cells) :]
    assert cosines(full, value).min() > 0.985
    bright = full > 0.1 * full.max(axis=1, keepdims=True)
    assert 0.8 < (np.abs(full - value) < 2 * sigma)[bright].mean() <= 1


def test_what_cannot_be_filled_is_refused():
    maps = sensor(22, 12, 8)
    field = np.stack([maps.xs, maps.ys], axis=1)
    with pytest.raises(Refusal, match="30 scan positions"):
        filled(part_of(maps, np.arange(30)), field, RADIUS_PX)
    with pytest.raises(Refusal, match="centres_px"):
        filled(maps, field[:, :1], RADIUS_PX)
    with pytest.raises(Refusal, match="patch radius"):
        filled(maps, field, 0.0)
