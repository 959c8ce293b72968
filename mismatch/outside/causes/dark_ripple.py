"""A ripple of counts that no light sent."""

import numpy as np

from physics.effect import Effect, Parameter, Values
from physics.pace import frame_interval_s
from physics.rendering import Rendering

# Cycles over the window that are looked at: slower ones are a slope.
SLOWEST = 2
# Cycles by which phases may run on from frame to frame.
TURNS = np.linspace(-0.5, 0.5, 401)


class DarkRipple(Effect):
    """Counts that no light sent, `counts` · (lifted + cos(2π (cycles · t - phase - running · time))) · exp(-fading t),
    t from 0 to 1 over the window.

    The supply of the detectors' bias switches, nearly in step with the laser; or the laser's driver rings in what the
    detectors' thresholds see, and that dies away. A pedestal is as high everywhere.
    """

    id = "dark_ripple"
    acts_on = "detector"
    order = -80
    sentence = "counts that no light sent rise and fall several times along the histogram"
    forms = (
        ("counts", "cycles", "phase"),
        ("counts", "cycles", "phase", "running"),
        ("counts", "cycles", "phase", "fading", "lifted"),
    )
    parameters = (
        Parameter(
            "counts",
            unit="counts",
            low=0.0,
            high=1e9,
            start=1.0,
            vanishes_at=0.0,
            axis="zone",
            sentence="Per bin, in the mean.",
        ),
        Parameter("cycles", "1", 1.0, 1e3, 8.0, "Over the window."),
        Parameter("phase", "1", -5.0, 5.0, 0.5, "Cycles from the window's begin to where it is highest, at time 0."),
        Parameter("running", "1/s", -1e3, 1e3, 0.0, "Cycles by which that grows in a second.", tries=(0.1,)),
        Parameter("fading", "1", 0.0, 20.0, 0.0, "Powers of e by which it dies away over the window.", tries=(1.0,)),
        Parameter(
            "lifted", "1", 0.0, 1.0, 1.0, "1 where it only adds, 0 where it swings about the level.", tries=(0.0,)
        ),
    )

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The frequency that most of the excess has, where little light is: fixed, and running with time."""
        light = np.maximum(expected - rendering.background, 0).mean(axis=(0, 1))
        dark = light <= np.median(light)
        mean = excess.mean(axis=1)
        waves = np.fft.rfft(np.where(dark, mean - mean[:, dark].mean(axis=1, keepdims=True), 0))[:, SLOWEST:]
        if not waves.size:
            return []
        time_s = np.asarray(rendering.light.time_s, float)
        running = TURNS / (frame_interval_s(time_s) or 1.0)
        return [self._start(waves, time_s, np.zeros(1)), self._start(waves, time_s, running)]

    def _start(self, waves: np.ndarray, time_s: np.ndarray, rates: np.ndarray) -> dict[str, float]:
        """Where waves (F, K) at times (F,) add up most, of some rates in cycles a second."""
        added = np.exp(2j * np.pi * rates[:, None] * time_s) @ waves
        rate, wave = np.unravel_index(int(np.argmax(np.abs(added))), added.shape)
        phase = float(-np.angle(added[rate, wave]) / (2 * np.pi) % 1)
        return {"cycles": float(SLOWEST + wave), "phase": phase, "running": float(np.clip(rates[rate], -1e3, 1e3))}

    def background(self, values: Values, rendering: Rendering) -> np.ndarray:
        """Dark counts with the ripple, (F, P, T)."""
        t = np.arange(rendering.clock.bins) / rendering.clock.bins
        ahead = values["phase"] + values["running"] * np.asarray(rendering.light.time_s, float)
        wave = values["lifted"] + np.cos(2 * np.pi * (values["cycles"] * t - ahead[:, None]))
        swing = np.atleast_1d(values["counts"])[:, None] * (wave * np.exp(-values["fading"] * t))[:, None]
        return np.maximum(rendering.background + swing, 0)


effect = DarkRipple()
