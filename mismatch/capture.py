"""Which capture would tell two causes apart: each is simulated under both, and the one that differs most is named."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mismatch.fit import Fit
from mismatch.poisson import LEAST
from mismatch.simulation import Simulation
from physics.light import Light, Return
from recordings.refusal import Refusal


@dataclass(frozen=True)
class Capture:
    """What a rig can do. change: of the light. gain: factor on the signal. words: as a person would be told."""

    words: str
    change: Callable[[Light], Light]
    gain: float = 1.0


def _stepped(factor: float) -> Callable[[Light], Light]:
    """The scene at `factor` times its range."""

    def change(light: Light) -> Light:
        f = np.float32(factor)
        ways = tuple(Return(way.range_m * f, way.strength / f**2) for way in light.returns)
        return replace(light, range_m=light.range_m * f, returns=ways)

    return change


def _dimmed(factor: float) -> Callable[[Light], Light]:
    """Targets that return `factor` times the light."""

    def change(light: Light) -> Light:
        f = np.float32(factor)
        ways = tuple(Return(way.range_m, way.strength * f) for way in light.returns)
        return replace(light, reflectance=light.reflectance * f, returns=ways)

    return change


def _tilted(light: Light) -> Light:
    """Surfaces turned away so that their cosine of incidence halves."""
    ways = tuple(Return(way.range_m, way.strength / 2) for way in light.returns)
    return replace(light, cosine=light.cosine / 2, returns=ways)


def _cycles(factor: float) -> Callable[[Light], Light]:
    """`factor` times as many laser shots in a frame."""

    def change(light: Light) -> Light:
        return light if light.laser_cycles is None else replace(light, laser_cycles=light.laser_cycles * factor)

    return change


def _still(light: Light) -> Light:
    """The first frame's scene all along."""
    first = [0] * light.frames
    ways = tuple(Return(way.range_m[first], way.strength[first]) for way in light.returns)
    return replace(
        light,
        range_m=light.range_m[first],
        reflectance=light.reflectance[first],
        cosine=light.cosine[first],
        returns=ways,
    )


def _longer(light: Light) -> Light:
    """The same in four times the time."""
    return replace(light, time_s=4 * light.time_s)


CAPTURES = (
    Capture("the same scene at twice the distance", _stepped(2.0)),
    Capture("the same scene at half the distance", _stepped(0.5)),
    Capture("the same scene with targets a tenth as reflective", _dimmed(0.1)),
    Capture("the same scene with the surfaces tilted to half their cosine of incidence", _tilted),
    Capture("the same scene with a quarter of the laser shots (iterations setting)", _cycles(0.25), 0.25),
    Capture("the same scene with four times the laser shots (iterations setting)", _cycles(4.0), 4.0),
    Capture("a scene at rest for as long as this recording", _still),
    Capture("the same scene moved four times as slowly", _longer),
    Capture("the emitter covered", _dimmed(0.0)),
)


def difference(simulation: Simulation, one: Fit, other: Fit, capture: Capture) -> float:
    """Deviance by which a capture would tell the two apart, a common gain left free."""
    there = replace(simulation.as_recorded(), light=capture.change(simulation.light), whole=None)
    try:
        a, b = (there.expected(capture.gain * fit.gain, fit.settings) for fit in (one, other))
    except Refusal:
        return 0.0
    background = simulation.background[:, None]
    signal = np.maximum(b - background, 0)
    weight = 1 / np.maximum(a, LEAST)
    scale = 1 + (signal * (a - b) * weight).sum() / max((signal**2 * weight).sum(), 1e-12)
    left = a - background - max(scale, 0) * (b - background)
    return float((left**2 * weight).sum())


def best_capture(simulation: Simulation, one: Fit, other: Fit) -> tuple[Capture, float]:
    """The capture that would tell two fits apart best, and the deviance by which."""
    return max(((c, difference(simulation, one, other, c)) for c in CAPTURES), key=lambda pair: pair[1])
