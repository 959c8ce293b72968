"""Every way that maps may be wrong, scored against a recording."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from fusion.map_changes import exchanged, mirrored, mirrored_order, shifted, shifts_px, twisted
from fusion.map_delays import best_bins, profiled, sought_bins, steps_bins
from fusion.map_scores import EARLIER, LATER, Candidates, corrected, delayed, precision, pulse_correction
from fusion.predictions import Bench
from fusion.reflectances import Reflectances

# Rounds in which the best way and the correction of the pulse are found in turn.
ROUNDS = 2


@dataclass(frozen=True, eq=False)
class Scores:
    """Log-likelihoods of a recording, summed over F frames, for each way the zones may look; as the maps say: `base`.

    base: (P,). shift: (S, S, P) of footprints displaced by y, x of `shifts_px`. table: (P, P), zone p with the map of
    zone q. order: by name, zones in mirrored order. image: by name, image of the maps mirrored. twist: by name,
    footprints turned, or of another size.
    """

    base: np.ndarray
    shift: np.ndarray
    table: np.ndarray
    order: dict[str, float]
    image: dict[str, float]
    twist: dict[str, float]

    @property
    def mirror_gain(self) -> dict[str, float]:
        """By name, gain over the maps as they are, of zones mirrored in their order or in the image."""
        total = float(self.base.sum())
        names = dict.fromkeys((*self.order, *self.image))
        return {n: max(self.order.get(n, -np.inf), self.image.get(n, -np.inf)) - total for n in names}

    @property
    def shift_gain(self) -> np.ndarray:
        """(S, S) gain of a shift of all."""
        whole = self.shift.sum(axis=-1)
        middle = len(whole) // 2
        return whole - whole[middle, middle]

    @property
    def twist_gain(self) -> float:
        """Gain of footprints turned or of another size."""
        return max(self.twist.values()) - float(self.base.sum())

    @property
    def pair_gain(self) -> np.ndarray:
        """(P, P) gain where two zones take each other's map."""
        own = np.diag(self.table)
        return self.table + self.table.T - own[:, None] - own[None]

    @property
    def assignment(self) -> np.ndarray:
        """(P,) the map of which zone each fits best, each map taken once."""
        return linear_sum_assignment(-self.table)[1]

    @property
    def order_gain(self) -> float:
        """Gain of that assignment."""
        return float(self.table[np.arange(len(self.table)), self.assignment].sum() - np.trace(self.table))

    @property
    def knowledge(self) -> float:
        """Gain of the maps as they are over maps drawn at random among the zones."""
        return float(np.trace(self.table) - self.table.mean(axis=1).sum())

    @property
    def wander_gain(self) -> float:
        """Gain of a shift for each zone by itself over a shift of all alike."""
        zones = self.shift.reshape(-1, self.shift.shape[-1])
        return float(zones.max(axis=0).sum() - zones.sum(axis=1).max())

    @property
    def disorder(self) -> float:
        """That gain as part of what the order of the maps gains."""
        return self.wander_gain / max(self.knowledge, 1.0)


class Trials:
    """All predicted signals of a bench; scores of the recorded counts, and of counts made up.

    kernel: the correction of the pulse found in the recording. orders: by name, (P,) which map each zone takes when the
    order is turned over. delay_bins: (P,) by which zones are late after that. observed: the scores of the recording.
    """

    def __init__(self, scene: Bench) -> None:
        self.scene = scene
        self.reflectances = Reflectances.of(scene.light.range_m)
        self.orders = mirrored_order(scene.where.zone_grid)
        shift, table = shifted(scene), exchanged(scene)
        image, twist = dict(mirrored(scene)), dict(twisted(scene))
        self._names, self._side = (tuple(image), tuple(twist)), len(shift)
        each = [shift.reshape(-1, *shift.shape[2:]).swapaxes(0, 1), table.transpose(2, 1, 0, 3)]
        each.append(np.stack([*image.values(), *twist.values()], axis=1))
        raw = np.concatenate(each, axis=1).swapaxes(1, 2).astype(np.float32)  # (F, P, C, T)
        weights, zones = self._weights(scene.counts), scene.sensor.zones
        self.kernel, self.delay_bins = np.eye(EARLIER + 1 + LATER)[EARLIER], np.zeros(zones)
        self._set(raw)
        for _ in range(ROUNDS):
            best = np.take_along_axis(raw, self._best(self.scored(scene.counts))[None, :, None, None], 2)[:, :, 0]
            timely = delayed(best, self.delay_bins)
            self.kernel = pulse_correction(scene.counts, weights, timely)
            tried = sought_bins(scene.sensor.bin_width_s)
            late = delayed(np.repeat(corrected(best, self.kernel)[:, :, None], len(tried), 2), tried)
            fits = Candidates.of(late).score(scene.counts, weights).sum(axis=0)
            self.delay_bins = best_bins(fits, scene.sensor.bin_width_s)
            self._set(raw)
        self.observed = self.scored(scene.counts)

    def _set(self, raw: np.ndarray) -> None:
        """What to compare: signals (F, P, C, T), their pulse corrected, each at three delays."""
        late = self.delay_bins[:, None] + steps_bins(self.scene.sensor.bin_width_s)
        pulse = corrected(raw, self.kernel)
        each = [delayed(pulse, late[:, None, k]) for k in range(late.shape[1])]
        self._candidates = Candidates.of(np.concatenate(each, axis=2))

    def _weights(self, counts: np.ndarray) -> np.ndarray:
        """(F, P, T) weight of every bin."""
        return precision(counts) * self.scene.reached

    def scored(self, counts: np.ndarray) -> Scores:
        """The scores of counts (F, P, T)."""
        by_delay = self._candidates.score(counts, self._weights(counts)).sum(axis=0)
        by_delay = by_delay.reshape(len(by_delay), 3, -1).swapaxes(1, 2)
        every = profiled(by_delay, self.delay_bins, self.scene.sensor.bin_width_s)  # (P, C)
        zones, side = np.arange(len(every)), self._side
        at = np.cumsum([side**2, len(zones), len(self._names[0])])
        shift, table, *others = np.split(every, at, axis=1)
        order = {name: float(table[zones, looks].sum()) for name, looks in self.orders.items()}
        image, twist = (
            dict(zip(n, v.sum(axis=0).tolist(), strict=True)) for n, v in zip(self._names, others, strict=True)
        )
        return Scores(np.diag(table), shift.T.reshape(side, side, -1), table, order, image, twist)

    def _best(self, scores: Scores) -> np.ndarray:
        """(P,) which candidates fit best."""
        flip = max(scores.image, key=scores.image.get)
        gains = (scores.shift_gain.max(), scores.order_gain, scores.image[flip] - scores.base.sum())
        zones, side = len(scores.table), self._side**2
        if gains[0] >= max(gains):
            return np.full(zones, scores.shift_gain.argmax())
        if gains[2] >= max(gains):
            return np.full(zones, side + zones + self._names[0].index(flip))
        return side + scores.assignment

    def made_up(self, spread: float, rng: np.random.Generator) -> Scores:
        """Scores of a recording that the maps are right about, of the same scene with another reflectance: off by
        log-normal factors of this standard deviation."""
        scene = self.scene
        light = scene.relit(np.exp(spread * self.reflectances.draw(rng)).astype(np.float32))
        signal = delayed(corrected(scene.signal(scene.where, light), self.kernel), self.delay_bins)
        level = np.median(scene.counts, axis=-1, keepdims=True)
        photons = np.maximum(((scene.counts - level) * scene.reached).sum(-1, keepdims=True), 0)
        signal *= photons / np.maximum((signal * scene.reached).sum(-1, keepdims=True), 1e-300)
        return self.scored(rng.poisson(signal + level).astype(float))


def peak_of(gain: np.ndarray) -> tuple[np.ndarray, bool]:
    """(2,) x, y in pixels where a gain (S, S) over shifts is largest, by a paraboloid through its neighbours; whether
    it lies within what was tried, not on its border."""
    row, column = np.unravel_index(gain.argmax(), gain.shape)
    tried = shifts_px()
    place = np.array([tried[column], tried[row]])
    inside = 0 < row < len(gain) - 1 and 0 < column < len(gain) - 1
    if not inside:
        return place, False
    near = gain[row - 1 : row + 2, column - 1 : column + 2]
    slope = np.array([near[:, 2].mean() - near[:, 0].mean(), near[2].mean() - near[0].mean()]) / 2
    bend = np.array([[near[1, 0] - 2 * near[1, 1] + near[1, 2], 0], [0, near[0, 1] - 2 * near[1, 1] + near[2, 1]]])
    bend[0, 1] = bend[1, 0] = (near[2, 2] - near[2, 0] - near[0, 2] + near[0, 0]) / 4
    if not (np.linalg.eigvalsh(bend) < 0).all():
        return place, True
    return place + np.clip(-np.linalg.solve(bend, slope), -1, 1) * (tried[1] - tried[0]), True
