"""The estimated response against photons drawn one by one, and against sums written out."""

import numpy as np
import pytest
from scipy.special import gammaln

from calibrate.impulse import fit_impulse
from calibrate.impulse.cells import in_steps
from calibrate.impulse.held_out import deviance_per_cell
from calibrate.impulse.likelihood import Counted, exposure
from calibrate.impulse.shape import Shape
from calibrate.impulse.sweep import Sweep
from physics.footprint import footprints
from physics.light import direct_light
from physics.pulse import ImpulseResponse, tailed_pulse, two_piece_pulse
from physics.sensor import SensorModel
from recordings.maps import ResponseMaps
from recordings.recording import Recording
from recordings.refusal import Refusal

C = 299_792_458.0
WIDTH = 100e-12
ZERO = 1e-9
META = '{"image_size": [120, 120]}'
CENTRES = [(30, 30), (90, 30), (30, 90), (90, 90)]
TWO_PIECE = two_piece_pulse(0.09e-9, 0.2e-9, WIDTH / 32)
TAILED = tailed_pulse(0.08e-9, 0.12e-9, 0.3e-9, 0.25, WIDTH / 32)


def maps():
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(-20, 140, 10), np.linspace(-20, 140, 10)))
    blobs = [1e4 * np.exp(-(((x - a) / 25) ** 2) - ((y - b) / 25) ** 2) for a, b in CENTRES]
    return ResponseMaps(np.stack(blobs).reshape(2, 2, -1), x, y, np.arange(x.size).astype(str), META)


def photons(sweep, pulse, signal, rng, delays=(0, 0, 0, 0), width_s=WIDTH):
    """(F, P, T) counts of photons drawn one by one: pixel, then delay; of each shot the first alone is registered.

    signal: photons of a frame and zone. Two more a bin are spread evenly over all bins.
    """
    bins, way = sweep.counts.shape[2], sweep.light.returns[0]
    counts = np.zeros(sweep.counts.shape)
    edges = pulse.time_s[0] + (pulse.time_s[1] - pulse.time_s[0]) * (np.arange(len(pulse.time_s) + 1) - 0.5)
    cumulative = np.concatenate([[0], np.cumsum(pulse.probability)])
    for f, p in np.ndindex(counts.shape[:2]):
        weight = (sweep.footprints.weights[p] * way.strength[f]).ravel().astype(float)
        pixel = rng.choice(weight.size, rng.poisson(signal), p=weight / weight.sum())
        time = ZERO + delays[p] * WIDTH + 2 * way.range_m[f].ravel()[pixel].astype(float) / C
        time = time + np.interp(rng.random(len(pixel)), cumulative, edges)
        time = np.append(time, rng.uniform(0, bins * width_s, rng.poisson(2 * bins)))
        if sweep.shots is not None:
            shot = rng.integers(0, int(sweep.shots[f]), len(time))
            order = np.lexsort((time, shot))
            time = time[order][np.unique(shot[order], return_index=True)[1]]
        counts[f, p] = np.histogram(time, np.arange(bins + 1) * width_s)[0]
    return counts


def swept(step_bins=0.3, frames=16, bins=48, shots=None, pixels=6):
    """A sweep of a plane square to the axis, as yet without counts."""
    depth = 0.12 + np.arange(frames) * step_bins * WIDTH * C / 2
    focal = 5.0 * pixels
    intrinsics = np.array([[focal, 0, (pixels - 1) / 2], [0, focal, (pixels - 1) / 2], [0, 0, 1]])
    light = direct_light(np.broadcast_to(depth[:, None, None], (frames, pixels, pixels)), intrinsics)
    return Sweep(light, footprints(maps(), (pixels, pixels)), np.zeros((frames, 4, bins)), WIDTH, ZERO, shots)


def counted(sweep, counts, **changes):
    fields = {name: getattr(sweep, name) for name in ("light", "footprints", "bin_width_s", "time_zero_s", "shots")}
    return Sweep(**(fields | {"counts": counts} | changes))


def drawn(pulse, signal=2e4, seed=1, delays=(0, 0, 0, 0), **kwargs):
    sweep = swept(**kwargs)
    return counted(sweep, photons(sweep, pulse, signal, np.random.default_rng(seed), delays))


def truth_on(estimate, pulse):
    """True probability of the estimate's steps, and which of them are bright enough for an error to be normal."""
    step = estimate.time_s[1] - estimate.time_s[0]
    edges = np.append(estimate.time_s, estimate.time_s[-1] + step) - step / 2
    true = np.diff(np.interp(edges, pulse.edges, pulse.edge_cumulative))
    return true, true > 0.05 * true.max()


def off(estimate, pulse):
    """Errors of the bright steps in standard errors."""
    true, bright = truth_on(estimate, pulse)
    return ((estimate.probability - true) / estimate.sigma)[bright]


@pytest.mark.parametrize("pulse", [TWO_PIECE, TAILED], ids=["two-piece", "tailed"])
def test_known_pulses_are_recovered_within_their_errors(pulse):
    found = fit_impulse(drawn(pulse))
    assert found.settled
    assert found.noise == 0
    true, bright = truth_on(found, pulse)
    # Some fifteen independent numbers, seen in many more steps.
    assert np.sqrt(np.mean(off(found, pulse) ** 2)) < 2
    assert np.median(found.sigma[bright] / true[bright]) < 0.03
    # Sub-bin: steps of an eighth of a bin, right to a few hundredths of the peak.
    assert np.abs(found.probability - true).max() < 0.05 * true.max()
    assert (np.abs(found.delay_s) < 4 * found.delay_sigma_s + 1e-13).all()


def test_photons_hidden_by_earlier_ones_do_not_bias():
    sweep = drawn(TAILED, signal=3e4, shots=3e4)
    hidden = 1 - sweep.counts.sum(axis=2).mean() / (3e4 + 96)
    assert hidden > 0.3
    found = fit_impulse(sweep)
    naive = fit_impulse(counted(sweep, sweep.counts, shots=None))
    assert np.sqrt(np.mean(off(found, TAILED) ** 2)) < 2
    assert np.sqrt(np.mean(off(naive, TAILED) ** 2)) > 10
    late = found.time_s > 0.4e-9
    share = TAILED.probability[TAILED.time_s > 0.4e-9].sum()
    assert found.probability[late].sum() == pytest.approx(share, rel=0.05)
    assert naive.probability[naive.time_s > 0.4e-9].sum() < 0.85 * share


def test_steps_of_a_bin_tell_less_and_say_so():
    """Two spikes 0.6 bins apart are seen where steps are finer than a bin; where they are not, errors cover them."""
    time = WIDTH / 32 * np.arange(-64, 65)
    spikes = sum(np.exp(-0.5 * ((time - t) / 12e-12) ** 2) for t in (-30e-12, 30e-12))
    spikes = ImpulseResponse(time, spikes / spikes.sum())
    errors = []
    for step, gap in ((0.23, 0.1), (1.0, 1.0)):
        found = fit_impulse(drawn(spikes, 1e4, pixels=4, step_bins=step, frames=26, bins=64), steps_per_bin=16)
        true, bright = truth_on(found, spikes)
        errors.append(np.median(found.sigma[bright] / true[bright]))
        assert np.sqrt(np.mean(off(found, spikes) ** 2)) < 2.5
        assert found.gap_bins == pytest.approx(gap, abs=0.1)
        if step < 1:
            middle, first, second = np.interp([0, -30e-12, 30e-12], found.time_s, found.probability)
            assert middle < 0.3 * min(first, second)
    assert errors[1] > 10 * errors[0]


def test_delays_between_zones_are_told_and_time_zero_is_taken_as_given():
    delays = np.array([0.4, -0.3, 0.1, -0.2])
    sweep = drawn(TWO_PIECE, delays=delays)
    found = fit_impulse(sweep)
    assert (np.abs(found.delay_s - delays * WIDTH) < 4 * found.delay_sigma_s).all()
    assert (found.delay_sigma_s < 0.02 * WIDTH).all()
    # An earlier time zero makes a later response: nothing tells the two apart.
    moved = fit_impulse(counted(sweep, sweep.counts, time_zero_s=ZERO - WIDTH))
    mean, late = (e.probability @ e.time_s for e in (found, moved))
    assert late - mean == pytest.approx(WIDTH, abs=0.02 * WIDTH)
    np.testing.assert_allclose(moved.delay_s, found.delay_s, atol=0.01 * WIDTH)


@pytest.mark.parametrize("part", [9, 11, 13])
def test_two_surfaces_in_every_zone_that_stand_still_tell_it_too(part):
    """A dark near one and a bright far one, in other parts in each zone: no pulse is where the mean of light is."""
    rng, frames = np.random.default_rng(11), 12
    near = np.arange(12)[:, None] + np.arange(12) < part
    depth, reflectance = (np.tile(np.where(near, *of), (frames, 1, 1)) for of in ((0.3, 0.8), (0.1, 1.0)))
    light = direct_light(depth, np.array([[60.0, 0, 5.5], [0, 60, 5.5], [0, 0, 1]]), reflectance)
    sweep = Sweep(light, footprints(maps(), (12, 12)), np.zeros((frames, 4, 110)), WIDTH, ZERO, None)
    found = fit_impulse(counted(sweep, photons(sweep, TWO_PIECE, 4000, rng)))
    assert np.abs(found.delay_s).max() < 5e-12
    mean = float(TWO_PIECE.time_s @ TWO_PIECE.probability)
    assert found.time_s @ found.probability == pytest.approx(mean, abs=8e-12)


@pytest.mark.parametrize("depth_m", [0.3, 0.3075])
def test_where_nothing_moves_the_whole_pulse_is_looked_at(depth_m):
    """All zones see it at one place in a bin: of those between no frame tells, and they are not its end."""
    pulse = two_piece_pulse(0.15e-9, 0.25e-9, WIDTH / 32)
    light = direct_light(np.full((12, 6, 6), depth_m), np.array([[90.0, 0, 2.5], [0, 90, 2.5], [0, 0, 1]]))
    sweep = Sweep(light, footprints(maps(), (6, 6)), np.zeros((12, 4, 64)), WIDTH, ZERO, None)
    found = fit_impulse(counted(sweep, photons(sweep, pulse, 2e4, np.random.default_rng(3))))
    first = pulse.time_s[np.searchsorted(np.cumsum(pulse.probability), 1e-3)]
    assert found.time_s[0] < first
    mean = float(pulse.time_s @ pulse.probability)
    assert found.time_s @ found.probability == pytest.approx(mean, abs=0.1 * WIDTH)


def test_the_bin_width_is_told_by_distances():
    sweep = swept(step_bins=0.9, frames=30, bins=64)
    counts = photons(sweep, TWO_PIECE, 1e4, np.random.default_rng(5), width_s=1.02 * WIDTH)
    found = fit_impulse(counted(sweep, counts), fit_bin_width=True)
    # Time zero is kept in bins; it was drawn in seconds, 0.2 bins of which go into the response.
    assert abs(found.bin_width_s - 1.02 * WIDTH) < 4 * found.bin_width_sigma_s
    assert found.bin_width_sigma_s < 2e-3 * WIDTH


def test_each_zone_may_have_its_own_response():
    sweep = swept()
    rng = np.random.default_rng(3)
    counts = photons(sweep, TWO_PIECE, 1e4, rng)
    counts[:, 2:] = photons(sweep, TAILED, 1e4, rng)[:, 2:]
    found = fit_impulse(counted(sweep, counts), per_zone=True)
    assert found.probability.shape == found.sigma.shape == (4, len(found.time_s))
    for zone, pulse in enumerate((TWO_PIECE, TWO_PIECE, TAILED, TAILED)):
        true, _ = truth_on(found, pulse)
        assert np.abs(found.probability[zone] - true).sum() < 0.05
        assert found.response(zone).probability.sum() == pytest.approx(1)


def test_a_sensor_takes_the_response_and_held_out_frames_agree():
    sweep = drawn(TAILED)
    found = fit_impulse(sweep.part(slice(0, None, 2)))
    SensorModel("any", (2, 2), 48, found.bin_width_s, ZERO, found.response())
    assert found.response().probability.sum() == pytest.approx(1)
    odd = sweep.part(slice(1, None, 2))
    own = deviance_per_cell(odd, found)
    wrong = np.exp(-0.5 * ((found.time_s - found.probability @ found.time_s) / (2 * WIDTH)) ** 2)
    assert (own < 1.4).all()
    assert (deviance_per_cell(odd, found, wrong / wrong.sum()) > 2 * own).all()


@pytest.mark.slow
@pytest.mark.parametrize("shots", [None, 2e4])
def test_errors_cover(shots):
    """Of bright steps, about 68 % lie within a standard error; steps of one fit are not independent, fits are."""
    inside = [
        np.mean(np.abs(off(fit_impulse(drawn(TAILED, 1e4, seed, shots=shots)), TAILED)) < 1) for seed in range(12)
    ]
    error = np.std(inside) / np.sqrt(len(inside))
    assert abs(np.mean(inside) - 0.683) < 3 * error + 0.03


def test_the_likelihood_is_that_of_first_photons():
    """Bin after bin, binomial: together the multinomial of which bin, or none, a shot falls into."""
    rng = np.random.default_rng(7)
    shots, rates = 500, rng.uniform(0, 80, 9)
    counts = rng.multinomial(shots, [*np.full(9, 0.06), 0.46])[:9].astype(float)

    def multinomial(rate):
        dark = np.exp(-np.cumsum(rate) / shots)
        share = np.append(np.append(1.0, dark[:-1]) * (1 - np.exp(-rate / shots)), dark[-1])
        every = np.append(counts, shots - counts.sum())
        return gammaln(shots + 1) - gammaln(every + 1).sum() + (every * np.log(share)).sum()

    alive = exposure(counts[None, None], np.array([float(shots)]))[0, 0]
    cells = Counted(counts, alive, np.full(9, float(shots)))
    other = rates * rng.uniform(0.5, 2, 9)
    gained = cells.log_likelihood(rates).sum() - cells.log_likelihood(other).sum()
    assert gained == pytest.approx(multinomial(rates) - multinomial(other))
    ahead = (cells.log_likelihood(rates + 1e-4) - cells.log_likelihood(rates - 1e-4)) / 2e-4
    np.testing.assert_allclose(cells.score_and_information(rates)[0], ahead, rtol=1e-5, atol=1e-6)
    coates = -shots * np.log(1 - counts / (alive * shots))
    np.testing.assert_allclose(cells.deviance(coates), 0, atol=1e-6)


def test_steps_of_the_response_fill_bins_as_written_out():
    sweep = swept(frames=2, pixels=5, bins=40)
    shape = Shape(8, 1.0, 0.0, 2.0)
    found = in_steps(sweep.arrivals(shape), 1)
    way, step = sweep.light.returns[0], WIDTH / 8
    expected = np.zeros_like(found)
    for f, (v, u), (j, offset) in (
        (f, vu, jo) for f in range(2) for vu in np.ndindex(5, 5) for jo in enumerate(shape.offsets)
    ):
        low = ZERO + 2 * float(way.range_m[f][v, u]) / C + (offset - 0.5) * step
        overlap = np.minimum(low + step, WIDTH * np.arange(1, 41)) - np.maximum(low, WIDTH * np.arange(40))
        light = float(sweep.footprints.weights[1, v, u] * way.strength[f][v, u])
        expected[f, :, j] += light * np.clip(overlap, 0, None) / step
    np.testing.assert_allclose(found, expected, atol=1e-5 * expected.max())


def test_what_cannot_be_estimated_from_is_refused():
    sweep = swept(frames=3)
    with pytest.raises(Refusal, match="counts are 0 in all frames"):
        fit_impulse(sweep)
    with pytest.raises(Refusal, match=r"counts\[0, 0\] sum to 96, expected fewer than the 90 laser shots"):
        fit_impulse(counted(sweep, np.full((3, 4, 48), 2.0), shots=90.0))
    with pytest.raises(Refusal, match="steps_per_bin is 0"):
        fit_impulse(sweep, steps_per_bin=0)
    with pytest.raises(Refusal, match=r"counts have shape \(2, 4, 48\), expected \(3, P, T\)"):
        counted(sweep, np.zeros((2, 4, 48)))
    with pytest.raises(Refusal, match="depth_m is missing"):
        Sweep.of(Recording(np.ones((2, 4, 8), np.uint32), [2, 2], 1e-10, 0.0, np.arange(2.0)), maps())
