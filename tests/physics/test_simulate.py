"""A simulated recording is Poisson around the nominal model of what it says it saw."""

import json
import weakref
from dataclasses import replace

import numpy as np
import pytest

from physics.clock import Clock
from physics.effects import find_effect
from physics.footprint import footprints
from physics.light import direct_light
from physics.nominal import ForwardModel
from physics.presets import preset
from physics.pulse import ImpulseResponse
from physics.scene.view import View, Views
from physics.simulate import simulate
from recordings.refusal import Refusal

INTRINSICS = np.array([[20.0, 0, 11.5], [0, 20.0, 7.5], [0, 0, 1]])


@pytest.fixture
def nine(maps):
    """Maps of 3 × 3 zones."""
    return replace(maps, responses=np.resize(maps.responses, (3, 3, len(maps.xs))))


def views(count=40, **changes):
    def each():
        rng = np.random.default_rng(3)
        for i in range(count):
            depth = rng.uniform(0.4, 2, (16, 24)).astype(np.float32)
            depth[:2] = np.nan
            yield View(10 + 0.1 * i, **({"depth_m": depth} | changes))

    return Views(INTRINSICS, each(), count, meta={"scene": "noise"})


def nominal(seen, maps):
    """What the model says of a recording by its own fields alone."""
    light = direct_light(seen.depth_m, seen.intrinsics, seen.reflectance, seen.incidence_cosine)
    pulse = ImpulseResponse(seen.irf_time_s, seen.irf)
    clock = Clock(float(seen.bin_width_s), seen.counts.shape[2], seen.time_zero_s, pulse)
    model = ForwardModel(light, footprints(maps, seen.depth_m.shape[1:]), clock, seen.background_counts)
    return model.expected(seen.meta["gain"])


def deviance(counts, expected):
    logs = np.where(counts > 0, counts * np.log(np.maximum(counts, 1) / expected), 0)
    return (2 * (expected - counts + logs)).mean()


def test_it_carries_all_that_the_model_needs(nine):
    stream, tally = simulate(views(), nine, preset("tmf8828-3x3-wide-long"), np.random.default_rng(0), peak=400)
    seen = stream.collect()
    assert seen.counts.shape == (40, 9, 128)
    assert deviance(seen.counts.astype(float), nominal(seen, nine)) == pytest.approx(1, abs=0.05)
    assert seen.timestamp_s[0] == 10
    assert seen.meta["scene"] == "noise"
    # Two rows of 16 have no depth; on the noise beside them incidence is known.
    assert (tally.pixels, tally.missing) == (40 * 16 * 24, 40 * 2 * 24)
    assert 300 < nominal(seen, nine)[0].max() < 420


def test_batches_do_not_show(nine, monkeypatch):
    sensor = replace(
        preset("tmf8828-3x3-wide-long"), effects=(find_effect("pile_up").at(), find_effect("impulse_tail").at())
    )
    whole = simulate(views(), nine, sensor, np.random.default_rng(0), gain=30.0)[0].collect()
    monkeypatch.setattr("physics.simulate.BATCH_FRAMES", 7)
    pieces = simulate(views(), nine, sensor, np.random.default_rng(0), gain=30.0)[0].collect()
    np.testing.assert_array_equal(whole.counts, pieces.counts)
    assert [effect["id"] for effect in json.loads(whole.meta_json)["effects"]] == ["pile_up", "impulse_tail"]


@pytest.mark.parametrize("lag", [0.23, -0.05, 2.0])
def test_batches_do_not_show_where_an_effect_looks_at_other_frames(nine, monkeypatch, lag):
    sensor = replace(preset("tmf8828-3x3-wide-long"), effects=(find_effect("time_lag").at(lag=lag),))
    seen = []
    for size in (40, 32, 7, 1):
        monkeypatch.setattr("physics.simulate.BATCH_FRAMES", size)
        seen.append(simulate(views(), nine, sensor, np.random.default_rng(0), gain=300.0)[0].collect())
        np.testing.assert_array_equal(seen[-1].counts, seen[0].counts)
    plain = simulate(views(), nine, replace(sensor, effects=()), np.random.default_rng(0), gain=300.0)[0].collect()
    np.testing.assert_array_equal(seen[0].depth_m, plain.depth_m)
    if lag == 2.0:
        # Twenty frames later: what is seen there is what frames held at the end of the recording show.
        later = np.clip(np.arange(40) + 20, 0, 39)
        assert deviance(seen[0].counts.astype(float), nominal(plain, nine)[later]) == pytest.approx(1, abs=0.05)


def test_frames_are_held_no_longer_than_an_effect_looks_back(nine, monkeypatch):
    """Memory stays bounded: of 60 frames no more than a batch and its reach are alive at any time."""
    monkeypatch.setattr("physics.simulate.BATCH_FRAMES", 4)
    alive, most = weakref.WeakSet(), []

    def each():
        for view in views(60).views:
            alive.add(view)
            most.append(len(alive))
            yield view

    scene = replace(views(60), views=each())
    sensor = replace(preset("tmf8828-3x3-wide-long"), effects=(find_effect("time_lag").at(lag=-0.25),))
    for _ in simulate(scene, nine, sensor, np.random.default_rng(0), gain=9.0)[0].frames:
        pass
    # A batch that is read, the three before it that are looked at, the batch before.
    assert max(most) <= 4 + 3 + 4 + 1


def test_the_frame_at_fault_is_named_in_any_batch(nine, monkeypatch):
    monkeypatch.setattr("physics.simulate.BATCH_FRAMES", 4)
    bad = (replace(view, depth_m=-view.depth_m) if i == 9 else view for i, view in enumerate(views(12).views))
    stream, _ = simulate(replace(views(12), views=bad), nine, preset("tmf8828-3x3-wide-long"), np.random.default_rng(0))
    with pytest.raises(Refusal, match=r"depth_m\[9, 2, 0\] is -"):
        stream.collect()


def test_effects_and_gloss_are_in_the_counts_alone(nine):
    plain = simulate(views(), nine, preset("tmf8828-3x3-wide-long"), np.random.default_rng(0), gain=9.0)[0].collect()
    shiny, _ = simulate(
        views(gloss=np.full((16, 24), 2.0)), nine, preset("tmf8828-3x3-wide-long"), np.random.default_rng(0), gain=9.0
    )
    seen = shiny.collect()
    background = 128 * seen.background_counts.sum() * 40
    assert (seen.counts.sum() - background) / (plain.counts.sum() - background) == pytest.approx(2, rel=0.01)
    np.testing.assert_array_equal(seen.incidence_cosine, plain.incidence_cosine)


@pytest.mark.parametrize(
    ("scene", "options", "sentence"),
    [
        (views(0), {}, "the scene has no view"),
        (views(depth_m=np.full((16, 24), np.nan)), {}, "no light of the first frame falls into any bin"),
        (views(depth_m=np.full((16, 24), -1.0)), {}, r"depth_m\[0, 0, 0\] is -1.0"),
        (views(reflectance=np.full((16, 24), 2.0)), {}, r"reflectance\[0, 0, 0\] is 2.0, expected 0 to 1"),
        (views(), {"gain": -1.0}, "gain is -1.0, expected a finite number above 0"),
        (views(), {"peak": np.inf}, "peak is inf"),
    ],
)
def test_what_cannot_be_simulated(nine, scene, options, sentence):
    with pytest.raises(Refusal, match=sentence):
        simulate(scene, nine, preset("tmf8828-3x3-wide-long"), np.random.default_rng(0), **options)


def test_maps_of_other_zones_and_frames_of_other_sizes(maps, nine):
    with pytest.raises(Refusal, match="the response maps have 2 x 2 zones but the sensor 3 x 3"):
        simulate(views(), maps, preset("tmf8828-3x3-wide-long"), np.random.default_rng(0))
    odd = Views(INTRINSICS, iter([View(0, np.ones((16, 24))), View(1, np.ones((16, 23)))]), 2)
    stream, _ = simulate(odd, nine, preset("tmf8828-3x3-wide-long"), np.random.default_rng(0))
    with pytest.raises(Refusal, match=r"depth_m\[1\] has shape \(16, 23\)"):
        stream.collect()


def test_one_command_from_public_rgbd_to_a_recording(shared_data, tmp_path, capsys):
    from difflidar.cli import main
    from recordings.files import load
    from recordings.maps_file import load_maps

    calibration = shared_data / "tmf8828_response_maps/spad_calib_3x3_longrange_bins15_35.npz"
    out = tmp_path / "seen.rrd"
    with pytest.raises(SystemExit) as end:
        main(["simulate", str(shared_data / "rgbd_open3d"), "--calibration", str(calibration), "--out", str(out)])
    assert end.value.code == 0
    assert "of the pixels contributed nothing" in capsys.readouterr().out
    seen = load(out)
    assert len(seen.counts) == 5
    assert deviance(seen.counts.astype(float), nominal(seen, load_maps(calibration))) == pytest.approx(1, abs=0.06)
    (tmp_path / "sensor.json").write_text('{"format": "difflidar-sensor/1", "effects": [{"id": "fog"}]}')
    with pytest.raises(SystemExit) as end:
        main(
            [
                "simulate",
                str(out),
                "--calibration",
                str(calibration),
                "--sensor",
                str(tmp_path / "sensor.json"),
                "--out",
                str(tmp_path / "no.rrd"),
            ]
        )
    assert end.value.code == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["seen.rrd", "sensor.json"]
