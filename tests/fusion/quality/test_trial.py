"""Recorded RGB-D frames: what is disturbed, and what comes out, on a small made-up scene."""

from dataclasses import replace

import numpy as np
import pytest

from fusion.quality.judge import ALTERNATIVES, judge
from fusion.quality.oracle import oracle_rms
from fusion.quality.tables import verdict
from fusion.quality.trial import COLOURS, Trial, painted, record_trial
from physics.scene.view import View
from recordings.maps_file import load_maps


def test_reflectance_changes_by_one_factor_for_each_colour():
    rng = np.random.default_rng(0)
    rgb = np.where(np.arange(64)[:, None] < 32, 40, 200)[..., None].astype(np.uint8) * np.ones((64, 64, 3), np.uint8)
    view = View(0.0, np.ones((64, 64)), reflectance=np.full((64, 64), 0.2))
    changed = painted(view, rgb, rng).reflectance
    assert len(np.unique(changed[:32].round(9))) == 1
    assert len(np.unique(changed.round(9))) <= COLOURS
    assert not np.allclose(changed, 0.2)


@pytest.mark.slow
def test_unmixing_beats_every_alternative_on_every_frame(shared_data):
    maps = load_maps(shared_data / "tmf8828_response_maps" / "spad_calib_3x3_longrange_bins15_35.npz")
    for name in ("rgbd_open3d", "rgbd_slambook2"):
        # Another seed than that of the document.
        trial = record_trial(shared_data / name, maps, np.random.default_rng(7))
        assert isinstance(trial, Trial)
        scores, _ = judge(trial)
        assert "above an alternative on 0 of 5 frames" in verdict([scores])
        mean = {key: np.mean([frame["rms"] for frame in frames]) for key, frames in scores.items()}
        assert mean["unmix"] < 0.75 * min(mean[key] for key in ALTERNATIVES)
        few = replace(trial, rgb=trial.rgb[:1], depth_m=trial.depth_m[:1])
        assert oracle_rms(few, 200)[0] < oracle_rms(few, 10)[0]
