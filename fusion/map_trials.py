"""Every way that maps may be wrong, scored against a recording."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.optimize import linear_sum_assignment

from fusion.map_changes import exchanged, mirrored, mirrored_order, shifted, shifts_px
from fusion.map_scores import corrected, precision, pulse_correction, score
from fusion.predictions import Bench

# Reflectance that nobody knows is off in blobs of this part of the image's width, a choice.
ALBEDO_BLOB = 0.06
# Rounds in which the best way and the correction of the pulse are found in turn.
ROUNDS = 2


@dataclass(frozen=True, eq=False)
class Scores:
    """Log-likelihoods of a recording, summed over F frames, for each way the zones may look; as the maps say: `base`.

    base: (F, P). shift: (S, S, P) of footprints displaced by y, x of `shifts_px`. table: (P, P), zone p with the map of
    zone q. order: by name, zones in mirrored order. image: by name, image of the maps mirrored.
    """

    base: np.ndarray
    shift: np.ndarray
    table: np.ndarray
    order: dict[str, float]
    image: dict[str, float]

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
    order is turned over. observed: the scores of the recording.
    """

    def __init__(self, scene: Bench) -> None:
        self.scene = scene
        shift, table, image = shifted(scene), exchanged(scene), dict(mirrored(scene))
        self.orders = mirrored_order(scene.where.zone_grid)
        self._shifted, self._table, self._image = shift, table, image
        for _ in range(ROUNDS):
            best = self._best(self.scored(scene.counts), shift, table, image)
            self.kernel = pulse_correction(scene.counts, self._weights(scene.counts), best)
            self._shifted, self._table = corrected(shift, self.kernel), corrected(table, self.kernel)
            self._image = {name: corrected(each, self.kernel) for name, each in image.items()}
        self.observed = self.scored(scene.counts)

    @property
    def as_is(self) -> np.ndarray:
        """(F, P, T) signal that the maps as they are predict, pulse corrected."""
        middle = len(self._shifted) // 2
        return self._shifted[middle, middle]

    def _weights(self, counts: np.ndarray) -> np.ndarray:
        """(F, P, T) weight of every bin."""
        return precision(counts) * self.scene.reached

    def scored(self, counts: np.ndarray) -> Scores:
        """The scores of counts (F, P, T)."""
        weights = self._weights(counts)
        by_zone, by_weight = counts.swapaxes(0, 1)[:, None], weights.swapaxes(0, 1)[:, None]
        table = score(by_zone, by_weight, self._table).sum(axis=-1)
        zones = np.arange(len(table))
        order = {name: float(table[zones, looks].sum()) for name, looks in self.orders.items()}
        image = {name: float(score(counts, weights, each).sum()) for name, each in self._image.items()}
        shift = score(counts, weights, self._shifted).sum(axis=-2)
        return Scores(score(counts, weights, self.as_is), shift, table, order, image)

    @staticmethod
    def _best(scores: Scores, shift: np.ndarray, table: np.ndarray, image: dict[str, np.ndarray]) -> np.ndarray:
        """(F, P, T) which of these signals fits best."""
        flip = max(scores.image, key=scores.image.get)
        gains = (scores.shift_gain.max(), scores.order_gain, scores.image[flip] - scores.base.sum())
        if gains[0] >= max(gains):
            return shift[np.unravel_index(scores.shift_gain.argmax(), scores.shift_gain.shape)]
        looks = scores.assignment
        return image[flip] if gains[2] >= max(gains) else table[np.arange(len(looks)), looks].swapaxes(0, 1)

    def made_up(self, spread: float, rng: np.random.Generator) -> Scores:
        """Scores of a recording that the maps are right about, of the same scene with another reflectance: off by
        log-normal factors of this standard deviation."""
        scene = self.scene
        frames, height, width = scene.light.range_m.shape
        blobs = ALBEDO_BLOB * width
        fields = [gaussian_filter(rng.standard_normal((height, width)), blobs) for _ in range(frames + 1)]
        fields = [field / field.std() for field in fields]
        # What is in view stays partly the same.
        mixed = (np.stack(fields[1:]) + fields[0]) / np.sqrt(2)
        signal = corrected(scene.signal(scene.where, scene.relit(np.exp(spread * mixed))), self.kernel)
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
