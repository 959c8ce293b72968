"""`ambient_pedestal`: sunlight, lamps, dark counts beyond the recorded background."""

import numpy as np
from scipy.signal import lombscargle

from physics.effect import Effect, LookAlike, Parameter, Values
from physics.glow import glow
from physics.pace import frame_interval_s
from physics.rendering import Rendering
from physics.walk import BETWEEN, LEVELS, walk_parameters, walk_starts, walked

# Frames that tell a beat from a trend. Of what they show most, they show that part of a wave which counts as seen.
FEWEST, SEEN = 8, 1e-2
# How often lamps on the mains flicker, and by how much more or less.
MAINS_HZ, MAINS_OFF_HZ = (100.0, 120.0), 0.5
# Levels of a walk, one fewer than others have: what walks has a number of its own.
WALKED = 5
# Logarithm of how much brighter or fainter it is at most.
MOST_JUMP = 5.0


class AmbientPedestal(Effect):
    """Photons that no laser sent arrive evenly in time: level · e^w + growth·t more in every bin after t seconds.

    w(t) is 0 where nothing else is said; where clouds pass it walks, and it jumps where lamps are switched
    (`physics.walk`). Lamps on the mains flicker, and what is left of that in frames beats with them: swing_sin ·
    sin φ + swing_cos · cos φ, φ = 2π · frequency · t. Where the same light is brighter than when it was recorded
    there is `more` of the recorded background in each zone. Where it falls on what the zones see, each has `lit`
    times how bright that is (`physics.glow`), which goes with the scene from frame to frame.
    A background that is less than recorded, which negative growth may come to, is never less than none.
    """

    id = "ambient_pedestal"
    acts_on = "detector"
    sentence = "Light other than the laser's, or dark counts, adds the same number of counts to every bin."
    look_alikes = (
        LookAlike("stray_light", "Cover the emitter: a pedestal stays, stray light goes."),
        LookAlike(
            "scattering_medium",
            "Cover the emitter: a pedestal stays and is flat, backscatter goes and falls with time.",
        ),
        LookAlike("afterpulsing", "Cover the emitter: a pedestal stays, afterpulses go."),
    )
    forms = (
        ("level",),
        ("level", "growth"),
        ("more",),
        ("lit",),
        ("level", "swing_sin", "swing_cos", "frequency"),
        ("level", *LEVELS[:WALKED]),
        ("level", *LEVELS[:WALKED], *BETWEEN[:WALKED]),
        ("level", "jump"),
    )
    parameters = (
        Parameter(
            "level",
            unit="counts",
            low=0.0,
            high=1e7,
            start=10.0,
            vanishes_at=0.0,
            axis="zone",
            sentence="Counts per bin and frame beyond the recorded background.",
        ),
        Parameter(
            "growth",
            unit="counts/s",
            low=-1e6,
            high=1e6,
            start=1.0,
            vanishes_at=0.0,
            sentence="Counts per bin and frame by which it is more after a second, in all zones.",
        ),
        Parameter(
            "more",
            unit="1",
            low=0.0,
            high=1e4,
            start=0.1,
            vanishes_at=0.0,
            sentence="Part of the recorded background that comes on top of it.",
        ),
        Parameter(
            "lit",
            "counts",
            0.0,
            1e7,
            10.0,
            "Counts per bin and frame in the mean zone where all it sees is white.",
            0.0,
        ),
        Parameter("swing_sin", "counts", -1e6, 1e6, 1.0, "By which it swings with the sine, in all zones.", 0.0),
        Parameter("swing_cos", "counts", -1e6, 1e6, 1.0, "By which it swings with the cosine.", 0.0),
        Parameter("frequency", "Hz", 0.0, 1e3, 1.0, "How often it does in a second, or seems to in frames that few."),
        *walk_parameters("1", MOST_JUMP, 0.3, WALKED),
    )

    def background(self, values: Values, rendering: Rendering) -> np.ndarray:
        """(F, P, 1) as many counts more in each bin of a zone."""
        time_s = np.asarray(rendering.light.time_s)[:, None, None]
        known = rendering.background * (1 + values["more"])
        phase = 2 * np.pi * values["frequency"] * time_s
        more = np.atleast_1d(values["level"])[:, None] * np.exp(walked(values, time_s)) + values["growth"] * time_s
        more = more + values["swing_sin"] * np.sin(phase) + values["swing_cos"] * np.cos(phase)
        if values["lit"]:
            more = more + values["lit"] * glow(rendering.light, rendering.footprints)[..., None]
        return np.maximum(known + more, 0)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """A walk, a jump and a beat that explain most of what frames have more than expected in all of their bins."""
        time_s = np.asarray(rendering.light.time_s, float)
        told = (1 / np.maximum(expected, 1)).sum(axis=(1, 2))
        level = (excess / np.maximum(expected, 1)).sum(axis=(1, 2)) / told
        walks = walk_starts({p.name: p for p in self.parameters}, time_s, level, told)
        switched = [walk | _switched(walk["jump_at"], time_s, level, told) for walk in walks if "jump" in walk]
        return [walk for walk in walks if "jump" not in walk] + switched + _beat(time_s, level, told)


def _switched(at_s: float, time_s: np.ndarray, level: np.ndarray, told: np.ndarray) -> dict[str, float]:
    """What a lamp switched at a time has before, and the logarithm of what it has after it over that.

    Of levels (F,), weighted (F,). One that goes out, or was out, is as faint there as a jump can have it: from what is
    fainter by little no fit comes to that.
    """
    before, after = (float(np.average(level[part], weights=told[part])) for part in (time_s < at_s, time_s >= at_s))
    brighter = max(before, after)
    if not brighter > 0:
        return {}
    faintest = brighter * np.exp(-MOST_JUMP)
    before, after = max(before, faintest), max(after, faintest)
    return {"level": before, "jump": float(np.log(after / before))}


def _beat(time_s: np.ndarray, level: np.ndarray, told: np.ndarray) -> list[dict[str, float]]:
    """The wave that explains most of levels (F,), weighted (F,); none where frames are too few.

    Lomb 1976, Astrophys. Space Sci. 39, 447, with a mean of its own: of each frame's level as all its cells tell. It is
    slower than frames follow, or as lamps on the mains: frames that come unevenly tell these apart.
    """
    span_s = float(np.ptp(time_s))
    if len(time_s) < FEWEST or not span_s > 0:
        return []
    highest = 0.5 / frame_interval_s(time_s)
    bands = [(0.5 / span_s, highest), *((mains - MAINS_OFF_HZ, mains + MAINS_OFF_HZ) for mains in MAINS_HZ)]
    frequencies = np.concatenate([np.arange(*band, 0.2 / span_s) for band in bands])
    power = lombscargle(time_s, level, 2 * np.pi * frequencies, weights=told / told.sum(), floating_mean=True)
    if not power.any():
        return []
    frequency = float(frequencies[int(power.argmax())])
    phase = 2 * np.pi * frequency * time_s
    waves = np.stack([np.ones(len(phase)), np.sin(phase), np.cos(phase)], axis=1)
    weight = np.sqrt(told / told.max())
    # A beat of every other frame is seen at one phase alone, and its other part could be anything: it is none then.
    mean, sine, cosine = np.linalg.lstsq(waves * weight[:, None], level * weight, rcond=SEEN)[0]
    swings = {"swing_sin": float(sine), "swing_cos": float(cosine)}
    return [{"level": float(max(mean, np.hypot(sine, cosine) / 10)), "frequency": frequency} | swings]


effect = AmbientPedestal()
