import cv2
import numpy as np
import pytest

from calibrate.impulse import ImpulseEstimate
from recordings.refusal import Refusal
from viewers.impulse_plot import save_impulse_plot


def estimate(zones):
    """Of a pulse of 40 steps, one or as many as there are zones."""
    time = np.arange(40) * 2.5e-11
    pulse = np.exp(-time / 2e-10) / np.exp(-time / 2e-10).sum()
    rows = pulse if zones is None else np.tile(pulse, (zones, 1))
    fields = {name: np.zeros(()) for name in ImpulseEstimate.__dataclass_fields__}
    return ImpulseEstimate(**fields | {"time_s": time, "probability": rows, "sigma": 0.1 * rows, "bin_width_s": 2e-10})


@pytest.mark.parametrize("zones", [None, 3])
def test_a_picture_is_written(tmp_path, zones):
    save_impulse_plot(tmp_path / "pulse.png", estimate(zones))
    seen = cv2.imread(str(tmp_path / "pulse.png"))
    assert seen.shape == (504, 1320, 3)
    # Both halves hold a curve in colour.
    colourful = np.ptp(seen.astype(int), axis=2) > 60
    assert colourful[:, :660].any()
    assert colourful[:, 660:].any()


def test_nothing_is_written_where_there_is_no_folder(tmp_path):
    with pytest.raises(Refusal, match="does not exist"):
        save_impulse_plot(tmp_path / "none" / "pulse.png", estimate(None))
    assert list(tmp_path.iterdir()) == []
