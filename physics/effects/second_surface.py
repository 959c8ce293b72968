"""`second_surface`: glass or a half-transparent sheet."""

from dataclasses import replace

import numpy as np
from scipy.constants import speed_of_light
from scipy.special import expit

from physics.arrivals import Arrivals
from physics.effect import Effect, LookAlike, Parameter, Values
from physics.light import Light, Return
from physics.marks import in_ball, place_parameters
from physics.panes import likely_pane
from physics.passed_on import passed_on
from physics.rendering import Rendering
from physics.replicas import replicas
from physics.spreading import spread_by
from physics.surface_replicas import surface_replicas
from physics.told_apart import WHICH, numbers

# Ways to go with range that a fit begins at: by the inverse square, or not at all.
FALLOFFS = (2.0, 0.0)
# So many times as much must tell for part of the surfaces as for all that a fit begins there. What one zone passes more
# of its light than another of the same sheet, at most.
PARTLY, UNEVEN = 1.1, 0.8
# A thing that sends so much of its light from elsewhere is elsewhere.
WHOLE = 0.95
# Two pulses less than this part of a bin apart are one. Width of the ends of what is covered, in log range.
THIN_BINS, EDGE = 0.1, 0.02
# So many spacings are looked at for panes. Surfaces met at a smaller cosine than this are seen edge on.
PANES, LEAST_COSINE = 3, 0.1


class SecondSurface(Effect):
    """Part of the light returns from a second surface `spacing` behind the first, or before it where negative.

    Behind it is what the first surface lets pass, before it a sheet that sends part back before the light gets there.
    Either way the first is dimmer by `passed`, and the second pulse has of its light

        passed · reflectance · (r / (r + spacing))^falloff

    with falloff 2 where the second surface is lit as the first is, and 0 where its pulse goes with the first's at all
    ranges alike, as the veil of a coated target does, or a laser that fires a weak pulse in advance. Each zone may have
    a part of its own, where glass covers part of the view. A sheet at or behind the sensor is dark. One thing alone may
    be translucent, or stand behind glass: surfaces are told apart and followed through the frames by their geometry,
    the largest first (`segments`). So may part of a surface, as a window is set in a wall: a ball in space (`marks`).
    Panes come in pairs: a third surface may send back `again` times the second's light from `beyond` that. What is
    spacing metres behind along a surface's normal, `parallel` to it, is spacing / cosθ farther along the ray.
    """

    id = "second_surface"
    acts_on = "scene"
    sentence = "Part of the light returns from a second surface, a fixed distance behind the first or before it."
    look_alikes = (
        LookAlike("multipath", "Step the target in range: the distance of the two pulses stays, a bounce's changes."),
        LookAlike("impulse_tail", "Put an opaque target in its place: a tail stays, the second surface goes."),
        LookAlike("afterpulsing", "Put an opaque target in its place: an afterpulse stays, the second surface goes."),
        LookAlike("range_aliasing", "Step the target in range: a second surface follows, a far target's pulse stays."),
    )
    forms = (
        ("passed", "spacing"),
        ("passed", "spacing", "reflectance"),
        ("covered", "spacing", "reflectance", "nearest", "farthest"),
        ("one", "spacing", "reflectance"),
        ("pane", "spacing", "reflectance", "pane_x", "pane_y", "pane_z", "pane_size"),
        ("passed", "spacing", "again", "beyond"),
        ("parallel", "spacing", "reflectance"),
    )
    parameters = (
        Parameter(
            "passed", "1", 0.0, 1.0, 0.1, "Part of its light that the first surface leaves to the second.", 0.0, "zone"
        ),
        Parameter("covered", "1", 0.0, 1.0, 0.1, "The same, of surfaces within `nearest` and `farthest`.", 0.0),
        Parameter("one", "1", 0.0, 1.0, 0.1, "The same, of surface number `surface` only.", vanishes_at=0.0),
        *WHICH,
        Parameter("pane", "1", 0.0, 1.0, 0.1, "The same, of surfaces in a ball in space.", vanishes_at=0.0),
        Parameter("parallel", "1", 0.0, 1.0, 0.1, "The same, where spacing is along surfaces' normals.", 0.0),
        *place_parameters("pane"),
        # Of panes centimetres.
        Parameter("spacing", "m", -5.0, 5.0, 0.05, "How far behind the first, negative before it.", tries=(-0.2, 0.05)),
        Parameter("reflectance", "1", 0.1, 10.0, 1.0, "Reflectance of the second surface over that of the first."),
        Parameter("falloff", "1", 0.0, 4.0, 2.0, "Power of the ratio of ranges by which the second surface is dimmer."),
        Parameter("nearest", "m", 0.05, 20.0, 0.05, "Range from which on surfaces are covered."),
        Parameter("farthest", "m", 0.1, 100.0, 100.0, "Range up to which surfaces are covered."),
        Parameter("again", "1", 0.0, 10.0, 0.0, "Light of a third surface over that of the second, alike in range."),
        Parameter("beyond", "m", 0.0, 5.0, 0.05, "Optical distance from the second surface to the third."),
    )

    def reach(self, values: Values) -> tuple[float, float]:
        """Surfaces are followed, and numbered by their pixels, through all frames."""
        return (np.inf, np.inf) if values["one"] else (0.0, 0.0)

    def mixes(self, values: Values) -> bool:
        """Which surface is which a part of the frames knows."""
        return False

    def in_scene(self, values: Values) -> bool:
        """What pixels see of it is; a pane before the sensor is not."""
        return bool(values["one"] or values["pane"] or values["parallel"])

    def light(self, values: Values, rendering: Rendering) -> Light:
        """Of one thing, of part of a surface or along normals, in part once more from farther away or nearer."""
        light = rendering.light
        if not self.in_scene(values):
            return light
        direct, *others = light.returns
        part = values["one"] * (numbers(values, light) == round(values["surface"])) if values["one"] else 0.0
        part = np.minimum(part + values["parallel"], 1)
        slant = np.maximum(light.cosine, LEAST_COSINE) if values["parallel"] else 1.0
        if values["pane"]:
            part = np.minimum(part + values["pane"] * in_ball(values, "pane", light), 1)
        lost = part * direct.strength
        ranges = np.where(lost > 0, direct.range_m, 1)
        later = []
        for times, spacing in _others(values):
            along = np.where(lost > 0, spacing / slant, spacing)
            strength = lost * times * spread_by(ranges, along, values["falloff"])
            later.append(Return(np.maximum(ranges + along, 0).astype(np.float32), strength.astype(np.float32)))
        first = replace(direct, strength=(direct.strength - lost).astype(np.float32))
        return replace(light, returns=(first, *others, *later))

    def moves_light(self, values: Values) -> bool:
        """See `Effect`."""
        return bool(np.any(values["passed"]) or values["covered"])

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Each zone's light in part once more, later and spread over a larger sphere, or earlier over a smaller one."""
        first = rendering.arrivals
        if not (np.any(values["passed"]) or values["covered"]):
            return first
        lattice, zero = first.lattice, np.atleast_2d(rendering.clock.time_zero_s)[..., None]
        knots_s = lattice.first_s + lattice.step_s * np.arange(lattice.size)
        ranges = speed_of_light / 2 * np.maximum(knots_s - zero, lattice.step_s)
        passed = np.atleast_1d(values["passed"])[:, None]
        if values["covered"]:
            passed = np.minimum(passed + values["covered"] * _within(values, ranges), 1)
        later = [
            (passed * (times * spread_by(ranges, spacing, values["falloff"])), 2 * spacing / speed_of_light)
            for times, spacing in _others(values)
        ]
        return passed_on(first, passed, later)

    def strained(self, values: Values, rendering: Rendering) -> bool:
        """A sheet where the first surface is is its brightness; one that one zone alone passes is its delay."""
        thin = abs(values["spacing"]) < THIN_BINS * rendering.clock.bin_width_s * speed_of_light / 2
        return thin or bool(np.ptp(values["passed"]) > UNEVEN)

    def contradiction(self, values: Values, rendering: Rendering) -> str | None:
        """A thing is where its light is."""
        if max(values["one"], values["covered"], values["pane"]) > WHOLE:
            return "all light of a thing comes from elsewhere, so that it is not where depth has it"
        return None

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
        """The spacings at which most of an excess is a replica of what is expected, or of one surface in it."""

        def start(name: str, spacing_m: float, **where: float) -> dict[str, float]:
            spacing = self.parameter("spacing")
            apart = float(np.clip(spacing_m, spacing.low, spacing.high))
            return {name: self.parameter(name).start, "spacing": apart} | where

        found, (direct, *_) = [], rendering.light.returns
        facing = float(np.average(np.nan_to_num(rendering.light.cosine), weights=direct.strength + 1e-12))
        told = [(falloff, two) for falloff in FALLOFFS for two in replicas(excess, expected, rendering, falloff)]
        # What stray counts far before the pulse promise by one way to go with range may hide all that is there.
        metres = rendering.clock.bin_width_s * speed_of_light / 2
        for spacing_m in {round(two.spacing_m / metres): two.spacing_m for _, two in told}.values():
            for falloff in FALLOFFS:
                found.append(start("passed", spacing_m, falloff=falloff))
                found.append(start("parallel", spacing_m * facing, falloff=falloff))
        for falloff, two in told:
            if two.third is not None:
                third = dict(zip(("beyond", "again"), two.third, strict=True))
                third = {name: min(value, self.parameter(name).high) for name, value in third.items()}
                found.append(start("passed", two.spacing_m, falloff=falloff, **third))
            if two.evidence_there > PARTLY * two.evidence:
                ends = {"nearest": max(two.nearest_m, 0.05), "farthest": max(two.farthest_m, 0.1)}
                found.append(start("covered", two.spacing_m, falloff=falloff, **ends))
        alone = surface_replicas(excess, expected, rendering)
        found += [start("one", there.spacing_m, **there.surface) for there in alone]
        pane = likely_pane(excess, expected, rendering, list(dict.fromkeys(one["spacing"] for one in found))[:PANES])
        return found if pane is None else [*found, start("pane", pane[0], **pane[1])]


def _others(values: Values) -> list[tuple[float, float]]:
    """Of the surfaces beside the first: reflectance over its, and spacing."""
    second, third = values["reflectance"], values["reflectance"] * values["again"]
    return [(second, values["spacing"]), *([(third, values["spacing"] + values["beyond"])] if third else [])]


def _within(values: Values, range_m: np.ndarray) -> np.ndarray:
    """How far surfaces at these ranges are among the covered, 0 to 1."""
    log = np.log(range_m)
    return expit((log - np.log(values["nearest"])) / EDGE) * expit((np.log(values["farthest"]) - log) / EDGE)


effect = SecondSurface()
