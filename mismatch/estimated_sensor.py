"""What a recording does not say of its sensor is estimated from those of its frames that choose the model."""

import numpy as np
from scipy.optimize import brentq
from scipy.stats import poisson

from calibrate.impulse import fit_impulse
from calibrate.impulse.sweep import Sweep
from mismatch.blocks import halves
from mismatch.fit import fit_nominal
from mismatch.poisson import LEAST
from mismatch.simulation import Simulation
from physics.sensor import SensorModel
from recordings.maps import ResponseMaps
from recordings.recording import Recording
from recordings.refusal import Refusal

# Steps towards the likeliest pedestal: where most cells hold nothing else, few are needed.
STEPS = 30
# Signal is hardly any where it is less than this part of the pedestal.
HARDLY = 0.1
# Frames are many where a response is to be estimated; so many tell it as well.
ENOUGH = 48
# Zones are asked that see the scene at once in this part of the frames.
OFTEN = 0.5
# Chance by which counts before the first light speak against a pedestal.
REFUTED = 1e-3
# Cells that tell a pedestal, at the least.
FEW = 100


def estimated_sensor(recording: Recording, maps: ResponseMaps) -> tuple[SensorModel, str]:
    """The sensor with response and, where none is recorded, pedestal estimated; and a sentence on it.

    And delays of zones where time zero was no more than assumed: one that is stated holds, but for what all zones
    share, which is the response's. No frame that is held out takes part; nor does a zone, or a frame, that light of the
    scene does not reach: such a zone keeps its time zero, and its pedestal is what it counts.
    """
    sweep = _chosen(recording, maps)
    zones = _seeing(sweep.lit)
    lit = np.flatnonzero(sweep.lit[:, zones].all(axis=1))
    if not len(lit):
        raise Refusal("no light of the scene reaches any zone in the frames that choose, expected surfaces in view")
    sweep = sweep.part(lit)
    sweep = sweep.part(slice(None, None, max(1, len(sweep.counts) // ENOUGH)))
    estimate = fit_impulse(sweep, zones=zones)
    delay_s, pedestal = np.zeros(sweep.counts.shape[1]), sweep.counts.mean(axis=(0, 2))
    pedestal[zones] = np.median(estimate.pedestal, axis=0)
    meta, said = recording.meta, f"estimated from {len(sweep.counts)} frames of the recording"
    sources, lacking = {"pulse": said}, ["impulse response"]
    if recording.assumes("time_zero_s"):
        delay_s[zones] = estimate.delay_s
        sources["time_zero_s"] = f"as recorded, and delays of zones {said}"
        lacking.append("delays of zones")
    # The pedestal of lit frames holds what lamps add to a recorded one, which is for effects to say.
    level = recording.background_counts
    if level is None:
        level, sources["background_counts"] = pedestal, said
        lacking.append("pedestal")
    sensor = SensorModel(
        name=str(meta.get("sensor", "")),
        mode=str(meta.get("mode", "")),
        zone_grid=tuple(int(n) for n in recording.zone_grid),
        bins=sweep.counts.shape[2],
        bin_width_s=estimate.bin_width_s,
        time_zero_s=np.asarray(sweep.time_zero_s, float) + delay_s,
        pulse=estimate.response(None),
        background_counts=np.asarray(level, float),
        sources=sources,
    )
    return sensor, f"What is not recorded is {said}, none of them held out: {', '.join(lacking)}."


def _chosen(recording: Recording, maps: ResponseMaps) -> Sweep:
    """Of the frames that choose the model those that show some depth."""
    sweep, chosen = Sweep.of(recording, maps, None, 0.0), halves(len(recording.counts))[0]
    depth = np.asarray(recording.depth_m)
    shown = np.ones(len(recording.counts), bool) if depth.ndim == 2 else np.isfinite(depth).any(axis=(1, 2))
    place = np.cumsum(shown) - 1
    return sweep.part(place[chosen[shown[chosen]]])


def _seeing(lit: np.ndarray) -> list[int]:
    """Zones of which all see the scene at once in half of the frames or more; the fewest others are left out.

    lit: (F, P) whether light of the scene reaches a zone.
    """
    zones = list(np.argsort(-lit.mean(axis=0), kind="stable"))
    while len(zones) > 1 and lit[:, zones].all(axis=1).mean() < OFTEN:
        zones.pop()
    return sorted(int(zone) for zone in zones)


def likeliest_pedestal(simulation: Simulation) -> np.ndarray:
    """(P,) counts per bin that no laser sent, the likeliest of all chosen frames together, beside their signal.

    Frame by frame and by its logarithm, as it is estimated beside the response, it is never nothing. Signal and
    pedestal add up, so that each step gives both their part of every count (Dempster, Laird and Rubin 1977). Only cells
    take part in which there is hardly any signal, of zones that have such: elsewhere it would take up what is amiss
    with that.
    """
    part = simulation.of(halves(len(simulation.counts))[0])
    signal = np.maximum(fit_nominal(part).expected - part.dark, 0)
    level = np.asarray(simulation.background, float)
    dark = signal < HARDLY * level[:, None]
    cells = dark.sum(axis=(0, 2))
    for _ in range(STEPS):
        expected = np.maximum(signal + level[:, None], LEAST * 1e-3)
        parts = np.sum(part.counts / expected, axis=(0, 2), where=dark) / np.maximum(cells, 1)
        level = np.where(cells > 0, level * parts, level)
    return np.array([_as_before(part.counts[:, zone], dark[:, zone], told) for zone, told in enumerate(level)])


def _as_before(counts: np.ndarray, dark: np.ndarray, level: float) -> float:
    """A zone's pedestal, or what it counts before the first light of each frame where that is clearly less.

    Later, light that comes late may pass for more: nothing does so before. counts, dark: (F, T).
    """
    before = np.cumsum(~dark, axis=-1) == 0
    seen, cells = float(counts[before].sum()), int(before.sum())
    return seen / cells if cells and poisson.cdf(seen, level * cells) < REFUTED else level


def quiet_pedestal(simulation: Simulation) -> np.ndarray:
    """(P,) counts per bin that no laser sent, of cells in which hardly any light is expected, most of them dark.

    For where the model is not known to be right: some of these cells hold light that it lacks, as what is passed from
    zone to zone. So counts are taken as no more than one above their median, and the level is the one of which Poisson
    counts, so cut off, have that mean.
    """
    fitted = fit_nominal(simulation)
    signal = np.maximum(fitted.expected - simulation.dark, 0)
    level = np.array(simulation.background, float)
    for zone in range(len(level)):
        counts = simulation.counts[:, zone]
        quiet = counts[signal[:, zone] < HARDLY * np.median(counts)]
        if quiet.size >= FEW:
            level[zone] = _cut_off_level(quiet, int(np.median(quiet)) + 1)
    return level


def _cut_off_level(counts: np.ndarray, most: int) -> float:
    """The mean of which Poisson counts, taken as no more than `most`, have the mean that these have."""
    below, due = np.arange(most), float(np.minimum(counts, most).mean())

    def beyond(mean: float) -> float:
        return float((poisson.pmf(below, mean) * below).sum() + most * poisson.sf(most - 1, mean)) - due

    return brentq(beyond, 0.0, 2.0 * most + 10.0)
