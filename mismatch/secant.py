"""Curvature of a fit: the information, or what its last steps tell of it where much is left."""

import numpy as np

# Pairs of a step and what it changed that are kept: the bottom of a bent valley has few directions.
PAIRS = 6
# Part of the curvature that was there which one pair may leave of it (Powell 1978).
LEAST_PART = 0.2
# Times what the information foretold that a step must win to say that it is too stiff; with no curvature it wins twice.
STIFF = 1.5
# Of so many coordinates the information is mostly nothing, and what steps tell would fill it.
MANY = 200


class Secant:
    """What steps of a fit tell of its curvature.

    The information leaves out how the model bends, times what is left. Where much is left steps by it overshoot, and
    damped ones creep along a bent valley. Each pair of a step and how it changed the score corrects it by the update of
    Broyden, Fletcher, Goldfarb and Shanno, damped so that it stays positive (Nocedal and Wright 2006, Numerical
    Optimization, procedure 18.2). Which of both is used is said by the last step: that which foretold better what it
    won (Dennis, Gay and Welsch 1981, ACM Transactions on Mathematical Software 7, section 4); and the information as
    long as no step had to be damped, or won far more than that foretold: of what looks at frames it is estimated from
    how scores scatter, which far from the best makes a slope a curvature.
    """

    def __init__(self) -> None:
        self._pairs: list[tuple[np.ndarray, np.ndarray]] = []
        self._last: tuple[np.ndarray, np.ndarray] | None = None
        self._models: tuple[np.ndarray, ...] = ()
        self._gradient = np.zeros(0)
        self._doubted = self._better = False

    def curvature(self, gradient: np.ndarray, information: np.ndarray) -> np.ndarray:
        """(N, N), for a step from where the score is `gradient` (N,)."""
        if len(gradient) > MANY:
            return information
        if self._last is not None:
            step, before = self._last
            self.learn(step, before - gradient)
        self._gradient, self._models = gradient, (information, self.corrected(information))
        return self._models[self._better and self._doubted]

    def took(self, step: np.ndarray, won: float, damped: bool) -> None:
        """That a step (N,) was taken from there. won: deviance. damped: whether the whole one would not do."""
        if len(step) > MANY:
            return
        foretold = [float(2 * self._gradient @ step - step @ model @ step) for model in self._models]
        self._last, self._doubted = (step, self._gradient), self._doubted or damped or won > STIFF * foretold[0]
        self._better = abs(foretold[1] - won) < abs(foretold[0] - won)

    def learn(self, step: np.ndarray, score_lost: np.ndarray) -> None:
        """Of a step (N,), and by how much the score (N,) fell on it."""
        self._pairs = [*self._pairs, (step, score_lost)][-PAIRS:]

    def corrected(self, curvature: np.ndarray) -> np.ndarray:
        """(N, N) of a positive curvature (N, N)."""
        for step, lost in self._pairs:
            along = curvature @ step
            there, found = float(step @ along), float(step @ lost)
            if there <= 0:
                continue
            if found < LEAST_PART * there:
                part = (1 - LEAST_PART) * there / (there - found)
                lost = part * lost + (1 - part) * along
                found = float(step @ lost)
            curvature = curvature + np.outer(lost, lost) / found - np.outer(along, along) / there
        return curvature
