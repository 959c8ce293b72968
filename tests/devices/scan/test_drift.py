"""Drift of the monitor pose, with known changes put in."""

import numpy as np
import pytest

from devices.scan.drift import drift
from devices.scan.journal import Frame, Journal, Sample


def looks(tmp_path, *, gain=0.0, shift=0.0, count=30, seed=0):
    journal, rng = Journal(tmp_path / "s.scanning"), np.random.default_rng(seed)
    bins = np.arange(64)
    for i in range(count):
        part = i / (count - 1)
        pulse = np.exp(-0.5 * ((bins - 30 - shift * part) / 3) ** 2)
        counts = rng.poisson(20 + 4e4 * (1 + gain * part) * np.tile(pulse, (3, 1))).astype(np.uint32)
        journal.add(Sample("monitor", 5, (Frame(100.0 * i, counts, None),), {}))
    return drift(journal)


@pytest.mark.parametrize(("gain", "shift"), [(0.0, 0.0), (0.05, 0.0), (-0.03, 0.2)])
def test_changes_that_were_put_in_come_out(tmp_path, gain, shift):
    found = looks(tmp_path, gain=gain, shift=shift)
    # Relative to the mean light, which is half the change above the first.
    assert abs(found["signal"] - gain / (1 + gain / 2)) < 4 * found["signal_sigma"] + 2e-3
    assert abs(found["arrival_bins"] - shift) < 4 * found["arrival_bins_sigma"] + 0.02
    assert found["looks"] == 30


def test_one_look_says_nothing(tmp_path):
    journal = Journal(tmp_path / "s.scanning")
    assert drift(journal) is None
    journal.add(Sample("monitor", 5, (Frame(0.0, np.ones((3, 8), np.uint32), None),), {}))
    assert drift(journal) is None


def test_two_looks_have_no_error(tmp_path):
    assert looks(tmp_path, count=2)["signal_sigma"] is None
