"""The likelihood of all counts as a function of response, delays and clock; what is a frame's own is eliminated."""

from dataclasses import dataclass, replace

import numpy as np

from calibrate.impulse.cells import Cells
from calibrate.impulse.shape import Shape, normalised

# Logarithms of gain and pedestal are held within some powers of e of where they start, where counts do not hold them.
LOOSE = 1 / 4.0**2
# Third differences leave three directions free, the constant one of which is no change at all; held loosely.
SPREAD = 1 / 30.0**2
STIFF = 1e8


@dataclass(frozen=True, eq=False)
class State:
    """Where the search is.

    coefficients: (K,) of the logarithm of the response. delay: (P,) steps. stretch: relative change of the bin width.
    log_gain, log_pedestal: (F, P). late: (F, P) steps by which a frame's light is later than that.
    """

    coefficients: np.ndarray
    delay: np.ndarray
    stretch: float
    log_gain: np.ndarray
    log_pedestal: np.ndarray
    late: np.ndarray


@dataclass(frozen=True, eq=False)
class Problem:
    """Counts by zone, with what is free.

    start: around which gains and pedestals are held. delays, clock: whether delays of zones and the bin width are free.
    base: delays and stretch at which the cells were made. jitter: standard deviation of `late`, steps.
    """

    cells: list[Cells]
    shape: Shape
    start: State
    delays: bool
    clock: bool
    base: State
    jitter: float

    def rate(self, zone: int, state: State, response: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rates (M,) of a zone's cells; light for the response (M,); by how much a delay of one step changes it."""
        cells = self.cells[zone]
        light = cells.design @ np.stack([response, moved(response)], axis=1)
        # Cells are made anew where delays have changed; in between, to first order.
        late = state.delay[zone] - self.base.delay[zone] + (state.late - self.base.late)[:, zone]
        late = late - (state.stretch - self.base.stretch) * cells.travel_steps
        light[:, 0] = np.maximum(light[:, 0] + late[cells.frame] * light[:, 1], 0)
        gain, pedestal = (np.exp(v[cells.frame, zone]) for v in (state.log_gain, state.log_pedestal))
        return gain * light[:, 0] + pedestal, light[:, 0], light[:, 1]

    def objective(self, state: State, smoothness: float, weights: list[np.ndarray]) -> float:
        """Weighted log likelihood less what the priors take."""
        response = normalised(self.shape.basis @ state.coefficients)
        value = -0.5 * float(state.coefficients @ self.prior(smoothness) @ state.coefficients)
        value -= 0.5 * float(self.firmness @ np.square(self.held(state)).sum(axis=(1, 2)))
        value -= 0.5 * STIFF * float(state.delay.mean() ** 2)
        for zone, cells in enumerate(self.cells):
            rate, _, _ = self.rate(zone, state, response)
            value += float(weights[zone] @ cells.counted.log_likelihood(rate))
        return value

    def prior(self, smoothness: float) -> np.ndarray:
        """(K, K) precision of the coefficients."""
        return smoothness * self.shape.roughness + SPREAD * np.eye(self.shape.basis.shape[1])

    def step(self, state: State, smoothness: float, weights: list[np.ndarray]) -> tuple[State, np.ndarray, np.ndarray]:
        """A scoring step, as a state of differences; the information (Q, Q) of what is common to all frames; and the
        variance (F, P) that the counts leave to `late`, steps².

        Gain, pedestal and lateness, three to a frame and zone, are eliminated (Schur complement).
        """
        basis = self.shape.basis
        response = normalised(basis @ state.coefficients)
        k, p = basis.shape[1], len(self.cells) if self.delays else 0
        size = k + p + (1 if self.clock else 0)
        information, score = np.zeros((size, size)), np.zeros(size)
        information[:k, :k] = self.prior(smoothness)
        score[:k] = -information[:k, :k] @ state.coefficients
        if p:
            information[k : k + p, k : k + p] += STIFF / p**2
            score[k : k + p] -= STIFF * state.delay.mean() / p
        tangent = response[:, None] * (basis - response @ basis)
        own_steps, spread = [], []
        for zone, cells in enumerate(self.cells):
            own, inner, pull, first, second = self.own(zone, state, response, weights[zone])
            gain = np.exp(state.log_gain[cells.frame, zone])
            common = np.zeros((len(first), size))
            common[:, :k] = gain[:, None] * (cells.design @ tangent)
            if p:
                common[:, k + zone] = own[:, 2]
            if self.clock:
                common[:, -1] = -own[:, 2] * cells.travel_steps[cells.frame]
            cross = crossed(cells, common, own, second)
            solved = np.linalg.solve(inner, np.concatenate([cross, pull[..., None]], axis=2))
            information += common.T @ (second[:, None] * common) - np.einsum("fiq,fir->qr", cross, solved[..., :-1])
            score += common.T @ first - np.einsum("fiq,fi->q", cross, solved[..., -1])
            own_steps.append(solved)
            spread.append(np.linalg.inv(inner)[:, 2, 2])
        change = np.linalg.solve(information, score)
        own = np.stack([s[..., -1] - s[..., :-1] @ change for s in own_steps], axis=1)
        delay = change[k : k + p] if p else np.zeros(len(self.cells))
        stretch = float(change[-1]) if self.clock else 0.0
        return State(change[:k], delay, stretch, *np.moveaxis(own, -1, 0)), information, np.stack(spread, axis=1)

    def own(self, zone: int, state: State, response: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, ...]:
        """What gain, pedestal and lateness of each frame do to a zone's cells.

        Derivatives (M, 3) of the rates; information (F, 3, 3) and score (F, 3) of the three, with what holds them;
        score and information (M,) of the rates.
        """
        cells = self.cells[zone]
        rate, light, moving = self.rate(zone, state, response)
        first, second = (v * weights for v in cells.counted.score_and_information(rate))
        gain, pedestal = (np.exp(v[cells.frame, zone]) for v in (state.log_gain, state.log_pedestal))
        own = np.stack([gain * light, pedestal, gain * moving], axis=1)
        inner = crossed(cells, own, own, second) + np.diag(self.firmness)
        pull = cells.by_frame(own * first[:, None]) - self.firmness * self.held(state)[:, :, zone].T
        return own, inner, pull, first, second

    @property
    def firmness(self) -> np.ndarray:
        """(3,) precision with which gains, pedestals and lateness are held."""
        return np.array([LOOSE, LOOSE, 1 / self.jitter**2])

    def held(self, state: State) -> np.ndarray:
        """(3, F, P) how far they are from where they are held."""
        gain, pedestal = state.log_gain - self.start.log_gain, state.log_pedestal - self.start.log_pedestal
        return np.stack([gain, pedestal, state.late])


def crossed(cells: Cells, common: np.ndarray, own: np.ndarray, information: np.ndarray) -> np.ndarray:
    """(F, 3, Q) information that each frame's cells give on its own three (M, 3) and on others (M, Q) together."""
    return np.stack([cells.by_frame(common * (information * column)[:, None]) for column in own.T], axis=1)


def moved(response: np.ndarray) -> np.ndarray:
    """(N,) by how much a delay of one step changes the response: central differences."""
    wide = np.pad(response, 1)
    return (wide[:-2] - wide[2:]) / 2


def plus(state: State, change: State, part: float) -> State:
    """The state, a part of the change further."""
    return replace(
        state, **{name: getattr(state, name) + part * getattr(change, name) for name in state.__dataclass_fields__}
    )
