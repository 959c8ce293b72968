"""Reflectance that goes to and fro over surfaces: a wave in space, and that which an excess of counts tells."""

from itertools import product

import numpy as np

from physics.effect import Parameter, Values
from physics.light import Light
from physics.marks import looked_at, places_kept, received
from physics.rendering import Rendering

NAMES = ("wave_x", "wave_y", "wave_z")
# Waves through what is seen, corner to corner, that are looked for; and in which directions, of which the opposite ones
# are the same.
WAVES = (0.7, 1.2, 2.0, 3.5)
DIRECTIONS = [way for way in product((-1, 0, 1), repeat=3) if way > (0, 0, 0)]
LONGEST = 100.0

WAVE = (
    Parameter("wave_sin", "1", -3.0, 3.0, 0.1, "Logarithm of the factor a quarter of a wave from the start.", 0.0),
    Parameter("wave_cos", "1", -3.0, 3.0, 0.1, "The same where the camera was when the session began.", 0.0),
    Parameter("wave_x", "rad/m", -LONGEST, LONGEST, 5.0, "Phase of the wave by metres to the right, as it was then."),
    Parameter("wave_y", "rad/m", -LONGEST, LONGEST, 0.0, "The same by metres down."),
    Parameter("wave_z", "rad/m", -LONGEST, LONGEST, 0.0, "The same by metres ahead."),
)


def wave(values: Values, light: Light) -> np.ndarray:
    """(F, H, W) wave_sin · sin φ + wave_cos · cos φ, where φ is `wave_x` · x + `wave_y` · y + `wave_z` · z."""
    phase = sum(values[name] * along for name, along in zip(NAMES, places_kept(light), strict=True))
    return values["wave_sin"] * np.sin(phase) + values["wave_cos"] * np.cos(phase)


def likely_waves(
    excess: np.ndarray, expected: np.ndarray, rendering: Rendering, most: int = 2
) -> list[dict[str, float]]:
    """Waves of reflectance that explain most of an excess by zone and frame, the best first; `NAMES` of each.

    excess, expected: (F, P, T) counts. By weighted least squares of what each zone receives in all of a sine and of a
    cosine, beside a gain of the whole.
    """
    light, some = rendering.light, looked_at(rendering.light)
    strength = np.nan_to_num(light.returns[0].strength[some]).astype(float)
    weights, seen = rendering.footprints.weights[some], strength > 0
    if not seen.any():
        return []
    points = [along[some] for along in places_kept(light)]
    across = max(float(np.linalg.norm([np.ptp(along[seen]) for along in points])), 1e-9)
    root = 1 / np.sqrt(np.maximum(expected.sum(axis=-1), 1))
    signal = (np.maximum(expected - rendering.background, 0).sum(axis=-1) * root).ravel()
    signal = signal / max(float(np.linalg.norm(signal)), 1e-300)
    amiss = (excess.sum(axis=-1) * root).ravel()
    found = []
    for way, waves in product(DIRECTIONS, WAVES):
        vector = np.minimum(2 * np.pi * waves / across, LONGEST) * np.array(way) / np.linalg.norm(way)
        phase = sum(k * along for k, along in zip(vector, points, strict=True))
        both = [(received(strength * of(phase), weights) * root).ravel() for of in (np.sin, np.cos)]
        both = np.stack([one - signal * (signal @ one) for one in both], axis=1)
        gained = amiss @ both @ np.linalg.lstsq(both, amiss, rcond=1e-9)[0]
        found.append((float(gained), dict(zip(NAMES, vector.tolist(), strict=True))))
    return [place for _, place in sorted(found, key=lambda one: -one[0])[:most]]
