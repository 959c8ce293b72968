"""Check a calibration by reconstruction: do the maps predict the histograms of a scene whose depth is known?"""

from dataclasses import asdict, dataclass

import numpy as np
from scipy.constants import speed_of_light

from fusion.depths import zone_depths
from fusion.map_departure import Departure, departure, doubt, joined, settled
from fusion.map_foreign import foreign, implausible, twisted
from fusion.map_null import SHOWN_SIGMAS, TOLD_PX, Null, null_of
from fusion.map_scores import misfit, precision
from fusion.map_trials import Trials
from fusion.mount import mounted
from fusion.predictions import Bench, bench
from fusion.range_response import range_response
from fusion.zone_view import ZoneDepths
from physics.sensor import SensorModel
from recordings.maps import ResponseMaps
from recordings.recording import Recording

# Maps may be wrong in so many ways at once.
MOST_DEPARTURES = 3
MOST_LATE_BINS = 4.0


@dataclass(frozen=True)
class ZoneAgreement:
    """One zone, maps as they are, over the frames compared.

    zone: its number. cosine: median cosine between predicted and recorded histogram, background subtracted.
    bias_m: by how much farther than predicted the whole histogram lies, where the two agree best. error_m: how far
    light lies on average from where it is predicted, distances of distributions over range (Wasserstein's first) made
    of the two histograms alike. Medians over frames, None where no frame has a range.
    """

    zone: int
    cosine: float
    bias_m: float | None
    error_m: float | None


@dataclass(frozen=True, eq=False)
class Check:
    """What a recording says of maps.

    kind: "fine", "another rig", "cannot tell", or kinds of departures joined by " and ". sentence: the verdict in
    words. evidence: sentences behind it. departures: what is wrong, in the order in which it was found.
    zones: agreement by zone. bias_m: median over zones, None where no zone has one. frames: which were compared.
    resolution_px: (2,) standard error in x, y to which a shift of the maps is known. reflectance_spread: by how much
    reflectance has to be off, log-normal, for right maps to fit as badly as these do at their best.
    """

    kind: str
    sentence: str
    evidence: tuple[str, ...]
    departures: tuple[Departure, ...]
    zones: tuple[ZoneAgreement, ...]
    bias_m: float | None
    frames: tuple[int, ...]
    resolution_px: tuple[float, float]
    reflectance_spread: float

    def as_dict(self) -> dict:
        """All of it as plain values."""
        found = [{"kind": d.kind, "gain": d.gain, "chance": d.chance, **d.values} for d in self.departures]
        return {
            "verdict": self.kind,
            "sentence": self.sentence,
            "evidence": list(self.evidence),
            "departures": found,
            "bias_m": self.bias_m,
            "zones": [asdict(zone) for zone in self.zones],
            "frames": list(self.frames),
            "resolution_px": list(self.resolution_px),
            "reflectance_spread": self.reflectance_spread,
        }


def check(recording: Recording, maps: ResponseMaps, sensor: SensorModel, rng: np.random.Generator) -> Check:
    """Whether `maps` say where the zones looked, by a recording with depth from the camera.

    The histograms are compared with those the forward model expects through the maps, and through maps that are
    displaced, mirrored, exchanged, turned or of another size. Brightness and pedestal of every histogram, one
    correction of the pulse and a delay of every zone are free; parallax is that of the mount, where recording or maps
    say it. What differences of log-likelihood mean is read off made-up recordings of the same scene by right maps, with
    photon noise and reflectances as wrong as the misfit allows. rng draws these. Raises `Refusal` where the recording
    has no depth, or zones and bins of recording, maps and sensor differ.
    """
    scene = bench(recording, maps, mounted(sensor, maps, recording.lidar_from_camera))
    trials = Trials(scene)
    null, found, now = null_of(trials, rng), [], maps
    step = departure(trials, null)
    reason = twisted(trials.observed, null, step)
    for _ in range(MOST_DEPARTURES):
        if step is None or reason is not None:
            break
        found, now = joined(found, step), step.undo(now)
        trials = Trials(scene.through(now))
        null = null_of(trials, rng)
        reason, found[-1] = implausible(step, null), settled(found[-1], trials, null)
        step = departure(trials, null)
        reason = reason or twisted(trials.observed, null, step)
    if reason is None:
        reason = foreign(trials.observed, null) or (step and "whatever is put right, something else is wrong then")
    kind, sentence, evidence = _verdict(found, reason, doubt(trials, null), null)
    zones = _agreement(scene)
    biases = [zone.bias_m for zone in zones if zone.bias_m is not None]
    return Check(
        kind,
        sentence,
        evidence,
        () if kind == "another rig" else tuple(found),
        zones,
        float(np.median(biases)) if biases else None,
        tuple(int(i) for i in scene.frames),
        tuple(float(s) for s in np.sqrt(np.diag(null.shift[1]))),
        null.spread,
    )


def _verdict(
    found: list[Departure], reason: str | None, doubted: str | None, null: Null
) -> tuple[str, str, tuple[str, ...]]:
    """Kind, sentence and evidence."""
    if reason is not None:
        return "another rig", "the maps are of another rig: no shift, mirror or order of them fits", (reason,)
    if found:
        evidence = tuple(
            f"{one.sentence}: put right, the log-likelihood rises by {one.gain:.0f}; by noise and errors of the model "
            f"it would by {max(one.chance, 0):.0f} at most"
            for one in found
        )
        return " and ".join(one.kind for one in found), "; ".join(one.sentence for one in found), evidence
    blind = [f"mirrored {name}" for name, told in null.mirrors_told.items() if not told]
    sigma = np.sqrt(np.diag(null.shift[1]))
    least = SHOWN_SIGMAS * sigma
    seen = f"a shift by more than {least[0]:.0f} px in x or {least[1]:.0f} px in y would have shown"
    if not null.shift_told or blind:
        missed = [*([] if null.shift_told else [f"shifted by {TOLD_PX:.0f} px"]), *blind]
        told = [name for name, known in null.mirrors_told.items() if known]
        words = f"cannot tell: the scene is too flat, or too few frames differ, to notice maps {', '.join(missed)}"
        if told and len(told) == len(null.mirrors_told):
            words += "; they are not mirrored in any way"
        elif told:
            words += f"; they are not mirrored {', nor '.join(told)}"
        return "cannot tell", words, (seen,)
    if doubted:
        return "cannot tell", f"cannot tell: {doubted}", (seen,)
    pairs = null.pairs_untold
    if pairs:
        told = ", ".join(f"{a} and {b}" for a, b in pairs)
        return "fine", f"the maps fit; that zones {told} are exchanged would not show in this scene", (seen,)
    return "fine", "the maps fit, as they are and no other way", (seen,)


def _agreement(scene: Bench) -> tuple[ZoneAgreement, ...]:
    """Every zone's histograms against those the maps as they are predict, brightness and level of each at its best."""
    recorded, signal = scene.counts, scene.signal(scene.where)
    level = np.median(recorded, axis=-1, keepdims=True)
    recorded = np.where(scene.reached, recorded, level)
    above = recorded - level
    product = (above * signal).sum(-1)
    size = np.sqrt((above**2).sum(-1) * (signal**2).sum(-1))
    cosine = np.where(size > 0, product / np.where(size > 0, size, 1), 0)
    scale = np.maximum(product, 0) / np.maximum((signal**2).sum(-1), 1e-300)
    response = range_response(scene.sensor)
    seen, foreseen = (zone_depths(each, response) for each in (recorded, signal * scale[..., None] + level))
    usable = np.isfinite(seen.surface_m).any(-1) & np.isfinite(foreseen.surface_m).any(-1)  # (F, P)
    bin_m = scene.sensor.bin_width_s * speed_of_light / 2
    late = _late_bins(recorded, precision(recorded) * scene.reached, signal) * bin_m
    apart = np.abs(_cumulative(seen) - _cumulative(foreseen)) @ np.gradient(response.range_m)
    zones = []
    for p in range(len(signal[0])):
        known = usable[:, p]
        bias, error = (float(np.median(v[known, p])) if known.any() else None for v in (late, apart))
        zones.append(ZoneAgreement(p, float(np.median(cosine[:, p])), bias, error))
    return tuple(zones)


def _late_bins(counts: np.ndarray, weights: np.ndarray, signal: np.ndarray) -> np.ndarray:
    """(F, P) bins by which each signal has to come later to fit best, MOST_LATE_BINS at most; a parabola between."""
    lags = np.arange(-MOST_LATE_BINS, MOST_LATE_BINS + 0.125, 0.25)
    bins = np.arange(signal.shape[-1])
    moved = [np.apply_along_axis(lambda s, lag=lag: np.interp(bins - lag, bins, s), -1, signal) for lag in lags]
    fits = -np.stack([misfit(counts, weights, each) for each in moved])
    best = np.clip(fits.argmax(axis=0), 1, len(lags) - 2)[None]
    before, at, after = (np.take_along_axis(fits, best + step, 0)[0] for step in (-1, 0, 1))
    bend = before - 2 * at + after
    between = np.where(bend < 0, 0.5 * (before - after) / np.where(bend < 0, bend, 1), 0)
    return lags[best[0]] + 0.25 * np.clip(between, -1, 1)


def _cumulative(depths: ZoneDepths) -> np.ndarray:
    """(F, P, B) part of the light that comes from each range or nearer."""
    total = depths.light.sum(axis=-1, keepdims=True)
    return np.cumsum(depths.light, axis=-1) / np.where(total > 0, total, 1)
