"""A periodic function of where in its bin a pulse falls."""

import numpy as np

from physics.effect import Values


def wave(values: Values, turns: np.ndarray, per_bin: float = np.inf) -> np.ndarray:
    """Cosine of a phase in turns, and its harmonics; as steep as it must be for its chords between knots to be it.

    values: `cos_2`, `sin_2`, `cos_3`, `sin_3`, how much of these comes on top.
    """
    total = np.cos(2 * np.pi * turns) / np.sinc(1 / per_bin) ** 2
    for order in (2, 3):
        phase, steeper = 2 * np.pi * order * turns, np.sinc(order / per_bin) ** -2
        total = total + steeper * (values[f"cos_{order}"] * np.cos(phase) + values[f"sin_{order}"] * np.sin(phase))
    return total
