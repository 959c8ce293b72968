"""The pulse broadens, on both flanks, the more light there is."""

from dataclasses import replace

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from physics.arrivals import Arrivals
from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering


class LevelBroadening(Effect):
    """Each photon's time is off by a normal deviate of standard deviation `width` · (S / level)^(`power` / 2), where S
    is the signal of its zone and frame; or the part `share` · S / level of them is, by one of `amiss`.

    An amplifier that slews, or a supply that gives way, makes strong pulses slow on both flanks. Where a photon meets
    one that is still busy, its own time alone is off.
    """

    id = "level_broadening"
    acts_on = "time"
    order = 1  # It goes by all light that arrives.
    sentence = "pulses are the broader, on both flanks, the more light there is"
    forms = (("width",), ("width", "power"), ("share", "amiss"))
    parameters = (
        Parameter(
            "width",
            unit="s",
            low=0.0,
            high=3e-9,
            start=1e-10,
            vanishes_at=0.0,
            power=2.0,
            sentence="Standard deviation at that level.",
        ),
        Parameter("power", "1", 0.5, 4.0, 1.0, "Power of the signal by which variance grows.", tries=(1.0, 2.0)),
        Parameter("share", "1", 0.0, 10.0, 0.05, "Part of photons whose time is off at that level.", vanishes_at=0.0),
        Parameter("amiss", "s", 1e-11, 3e-9, 5e-10, "Standard deviation by which it is."),
        Parameter("level", "counts", 1.0, 1e9, 1e4, "Counts of signal in a zone and frame."),
    )

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """At the level of the brighter ones."""
        signal = np.maximum(expected - rendering.background, 0).sum(axis=-1)
        level = self.parameter("level")
        return [{"level": float(np.clip(np.quantile(signal, 0.9), level.low, level.high))}]

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Light of each zone and frame blurred by its own sum."""
        light = rendering.arrivals.light
        signal = rendering.gain * light.sum(axis=-1) / values["level"]
        step_s = rendering.arrivals.lattice.step_s
        if values["width"]:
            light = _blurred(light, values["width"] * signal ** (values["power"] / 2) / step_s)
        if values["share"]:
            part = np.minimum(values["share"] * signal, 1)[..., None]
            light = light + part * (_blurred(light, np.full(signal.shape, values["amiss"] / step_s)) - light)
        return replace(rendering.arrivals, light=light)


def _blurred(light: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Light (F, P, N) blurred by a normal law of so many knots (F, P)."""
    # Room at the end for what the widest sends beyond it, so that nothing comes round.
    size = light.shape[-1]
    whole = next_fast_len(size + int(min(6 * steps.max(), size)) + 1, real=True)
    passed = np.exp(-0.5 * (2 * np.pi * rfftfreq(whole) * steps[..., None]) ** 2)
    blurred = irfft(rfft(light, whole, axis=-1) * passed, whole, axis=-1)[..., :size]
    # Rounding of a transform makes a little less than nothing of nothing.
    return np.maximum(blurred, 0)


effect = LevelBroadening()
