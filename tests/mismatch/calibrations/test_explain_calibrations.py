"""Pairs of maps made here, by formulas of their own, with one departure concealed in each."""

import json

import numpy as np
import pytest

from mismatch.calibrations import explain_calibrations
from recordings.maps import ResponseMaps
from recordings.refusal import Refusal

STEP = 12.0
WIDTH, HEIGHT = 480, 360


def positions():
    """Rows of a snake, with the jitter of found centres."""
    xs, ys = np.arange(12.0, WIDTH - 11, STEP), np.arange(12.0, HEIGHT - 11, STEP)
    rows = [np.stack([xs[:: 1 - 2 * (i % 2)], np.full(len(xs), y)], axis=1) for i, y in enumerate(ys)]
    return np.concatenate(rows) + 0.5 * np.random.default_rng(1).standard_normal((len(xs) * len(ys), 2))


def zones(xy, blur=0.0):
    """(4, K) four Gaussian footprints with a faint common light; a Gaussian blurred is a Gaussian."""
    out = []
    for cx, cy in ((170, 130), (310, 130), (170, 240), (310, 240)):
        before, after = np.array([38.0**2, 30.0**2]), np.array([38.0**2 + blur, 30.0**2 + blur])
        out.append(
            np.sqrt(before.prod() / after.prod())
            * np.exp(-((xy[:, 0] - cx) ** 2) / (2 * after[0]) - (xy[:, 1] - cy) ** 2 / (2 * after[1]))
        )
    return 4e6 * np.stack(out) * np.array([1.0, 0.8, 0.9, 1.1])[:, None]


def maps(values, xy, seed, noise=0.01):
    """With relative noise, and a faint one everywhere that goes with the unit."""
    rng = np.random.default_rng(seed)
    faint = 7e-5 * values.max() * rng.standard_normal(values.shape)
    seen = values * (1 + noise * rng.standard_normal(values.shape)) + faint
    ids = np.array([f"{i:04d}" for i in range(len(xy))])
    meta = json.dumps({"image_size": [WIDTH, HEIGHT]})
    return ResponseMaps(np.maximum(seen, 0).reshape(2, 2, -1), xy[:, 0], xy[:, 1], ids, meta)


def verdict_on(second, first=zones):
    """On the plain maps and those that `second` makes of (positions, plain maps)."""
    xy = positions()
    plain = first(xy)
    return explain_calibrations(maps(plain, xy, 2), maps(second(xy, plain) / 5, xy, 3))


def found(verdict):
    """Names to values."""
    return {e.id: {p.name: (p.value, p.sigma) for p in e.parameters} for e in verdict.effects}


def test_two_scans_that_differ_by_noise_agree():
    verdict = verdict_on(lambda xy, plain: plain)
    assert verdict.verdict == "agrees"
    assert verdict.effects == ()
    assert verdict.unexplained == ()
    assert verdict.after.one_minus_cosine < 1.5 * verdict.floor.one_minus_cosine + 1e-4


def test_a_shift_is_found_and_taken_out():
    verdict = verdict_on(lambda xy, plain: zones(xy - [2.5, -1.5]))
    assert verdict.verdict == "explained"
    assert verdict.effects[0].id == "footprint_shift"
    assert found(verdict)["footprint_shift"]["x"][0] == pytest.approx(2.5, abs=0.2)
    assert found(verdict)["footprint_shift"]["y"][0] == pytest.approx(-1.5, abs=0.2)
    assert verdict.after.displacement_px < verdict.before.displacement_px / 5
    assert verdict.multiples[0] == pytest.approx(1, abs=0.15)


def test_a_blur_is_found():
    verdict = verdict_on(lambda xy, plain: zones(xy, blur=150.0))
    assert verdict.effects[0].id == "footprint_blur"
    assert found(verdict)["footprint_blur"]["variance"][0] == pytest.approx(150, rel=0.25)


def test_zone_gains_are_found():
    gains = np.array([1.0, 1.3, 0.8, 1.1])
    verdict = verdict_on(lambda xy, plain: plain * gains[:, None])
    assert [e.id for e in verdict.effects] == ["zone_gain"]
    values = np.array([v for v, _ in found(verdict)["zone_gain"].values()])
    assert values - values.mean() == pytest.approx(np.log(gains) - np.log(gains).mean(), abs=0.02)


def test_stray_light_is_found():
    verdict = verdict_on(lambda xy, plain: plain + 0.015 * plain.sum(axis=0))
    assert verdict.effects[0].id == "stray_light"
    share = next(iter(found(verdict)["stray_light"].values()))
    assert share[0] == pytest.approx(0.015, abs=0.002)


def test_a_mirrored_ghost_is_found():
    verdict = verdict_on(lambda xy, plain: plain + 0.03 * zones([250.0 * 2, 190.0 * 2] - xy))
    assert verdict.effects[0].id == "stray_light"
    values = found(verdict)["stray_light"]
    assert values["share"][0] == pytest.approx(0.03, abs=0.004)
    assert values["centre_x"][0] == pytest.approx(250, abs=4)
    assert values["centre_y"][0] == pytest.approx(190, abs=4)


def test_rings_of_bin_phase_are_found():
    def ringed(xy, plain):
        reach = np.sqrt(1 + ((xy[:, 0] - 230) ** 2 + (xy[:, 1] - 170) ** 2) / 346.0**2)
        return plain * (1 + 0.15 * np.cos(2 * np.pi * (12.5 * reach - 0.3)))

    verdict = verdict_on(ringed)
    assert verdict.effects[0].id == "bin_phase"
    values = found(verdict)["bin_phase"]
    assert values["foot_x"][0] == pytest.approx(230, abs=8)
    assert values["foot_y"][0] == pytest.approx(170, abs=8)
    assert values["bins"][0] == pytest.approx(12.5, abs=1.0)
    assert verdict.after.one_minus_cosine < verdict.before.one_minus_cosine / 3


def test_losses_of_the_bright_are_found():
    verdict = verdict_on(lambda xy, plain: plain * np.exp(-0.4 * plain / plain.max()))
    assert verdict.effects[0].id == "pile_up"
    assert any(value == pytest.approx(0.4, abs=0.08) for value, _ in found(verdict)["pile_up"].values())


def test_a_lag_along_the_snake_is_told_from_a_shift():
    def late(xy, plain):
        return zones(xy - 0.3 * np.gradient(xy, axis=0) * (np.abs(np.gradient(xy, axis=0)[:, 1]) < 5)[:, None])

    verdict = verdict_on(late)
    assert verdict.effects[0].id == "time_lag"
    assert found(verdict)["time_lag"]["captures"][0] == pytest.approx(0.3, abs=0.05)


def test_what_no_departure_explains_stays_unknown():
    def strange(xy, plain):
        return plain * (1 + 0.3 * np.sin(xy[:, 0] / 17) * np.sin(xy[:, 1] / 19))

    verdict = verdict_on(strange)
    assert verdict.verdict == "unknown"
    assert verdict.unexplained
    assert verdict.heldout.explained > 3


def test_held_out_positions_of_the_second_do_not_predict_themselves():
    """Whatever the second shows where it is held out, the first carried to it stays as it was."""
    xy = positions()
    a, b = maps(zones(xy), xy, 2), zones(xy - [2.0, 0.0])
    from mismatch.calibrations.fitting import fit
    from mismatch.calibrations.pair import pair

    one = pair(a, maps(b, xy, 3))
    other = pair(a, maps(np.where(one.held, 0.9 * b, b), xy, 3))
    fits = [fit(p.of(~p.held), (), np.zeros(1), 0.1) for p in (one, other)]
    assert np.array_equal(one.held, other.held)
    assert fits[0].predicted(one) == pytest.approx(fits[1].predicted(other), rel=0.005)


def test_the_verdict_is_json_and_the_maps_are_maps():
    verdict = verdict_on(lambda xy, plain: zones(xy - [2.5, -1.5]))
    told = json.loads(verdict.text())
    assert told["format"] == "difflidar-calibrations-verdict/1"
    assert told["consistency"]["after"]["displacement_px"] == verdict.after.displacement_px
    assert verdict.a.responses.shape == verdict.b.responses.shape
    assert verdict.a.meta["departures_removed"] == ["footprint_shift"]


def test_a_scan_of_a_few_points_is_refused():
    xy = positions()[:30]
    with pytest.raises(Refusal, match="tiles"):
        explain_calibrations(maps(zones(xy), xy, 2), maps(zones(xy), xy, 3))


@pytest.mark.slow
def test_the_published_maps(shared_data):
    from recordings.maps_file import load_maps

    folder = shared_data / "tmf8828_response_maps"
    verdict = explain_calibrations(
        load_maps(folder / "spad_calib_3x3_longrange_bins15_35.npz"),
        load_maps(folder / "spad_calib_3x3_shortrange_bins45_75.npz"),
    )
    assert {"pile_up", "bin_phase"} <= {e.id for e in verdict.effects}
    assert verdict.verdict == "unknown"
    assert verdict.after.one_minus_cosine < 0.5 * verdict.before.one_minus_cosine
    assert verdict.after.displacement_px < 0.5 * verdict.before.displacement_px
    assert verdict.after.iou[1] > verdict.before.iou[1] + 0.02
    # Long-range bins of 57 mm over the distance that the short-range window, bins 45 to 75 of 13.9 mm, allows.
    assert 0.4 < found(verdict)["bin_phase"]["bins"][0] * 0.057 < 0.9
