"""What one zone receives shows in another as well: a reflection in the lens, a neighbouring wire."""

from dataclasses import replace
from typing import Any

import numpy as np

from physics.arrivals import Arrivals
from physics.effect import Effect, Parameter, Values
from physics.rendering import Rendering
from physics.replicas import DARK, correlation

# Which zone another's light comes from, by number of the parameter `of`.
OPPOSITE, SIDEWAYS, UPSIDE_DOWN, BEFORE, AFTER = range(1, 6)
# Deviance from which data tell whose light a zone receives, of several that may; and zones up to which they are asked.
TOLD, MOST_ZONES = 12.0, 25


class ZoneGhost(Effect):
    """Zone p also receives `share` of what another zone q(p) does, `delay` later or earlier.

    q is the zone opposite, through the centre of the grid, as light goes that lens and window reflect; that on the
    other side, left for right or top for bottom, amid the grid the zone itself; the one before or after it in order,
    as signals couple; or any: `source` is its number, and the zone's own where it receives nothing.
    """

    id = "zone_ghost"
    acts_on = "optics"
    order = -1
    sentence = "each zone receives part of what one other zone does"
    forms = (("share",), ("share", "delay"))
    parameters = (
        Parameter("share", "1", 0.0, 1.0, 0.02, "Part of the other zone's light.", vanishes_at=0.0, axis="zone"),
        Parameter("delay", "s", -10e-9, 10e-9, 0.5e-9, "By which it comes later."),
        Parameter(
            "of", "1", OPPOSITE, AFTER, OPPOSITE, "1 opposite, 2 left for right, 3 top for bottom, 4 before, 5 after."
        ),
        Parameter("source", "1", -1.0, 1e6, -1.0, "Which zone it comes from; -1 where `of` says that.", axis="zone"),
    )

    def arrivals(self, values: Values, rendering: Rendering) -> Arrivals:
        """Light by zone, and part of another zone's."""
        there = rendering.arrivals
        if not np.any(values["share"]):
            return there
        other, has = others(rendering.footprints.zone_grid, round(values["of"]))
        if np.any(np.asarray(values["source"]) >= 0):
            zones = np.arange(len(other))
            other = np.minimum(np.broadcast_to(values["source"], other.shape), len(zones) - 1).round().astype(int)
            has = other != zones
        ghost = replace(there, light=(np.asarray(values["share"]) * has)[:, None] * there.light[:, other])
        return replace(there, light=there.light + ghost.delayed(np.array(values["delay"])).light)

    def starts(self, excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, Any]]:
        """Each pair of zones at the delay at which most of an excess is a ghost: matched filters for white noise.

        Turin 1960, IRE Trans. Inf. Theory 6, 311.
        """
        bins, width = expected.shape[-1], rendering.clock.bin_width_s
        light, noise = np.maximum(expected - rendering.background, 0), 1 / np.maximum(expected, DARK)
        found = []
        for of in range(OPPOSITE, AFTER + 1):
            other, has = others(rendering.footprints.zone_grid, of)
            theirs = light[:, other] * has[:, None]
            promised = correlation(theirs, excess * noise).sum(axis=(0, 1))
            information = correlation(theirs**2, noise).sum(axis=(0, 1))
            evidence = np.where(information > 1, np.maximum(promised, 0) ** 2 / np.maximum(information, 1), 0)
            delay = (int(np.argmax(evidence)) - (bins - 1)) * width
            farthest = self.parameter("delay").high
            found += [{"of": float(of), "delay": at} for at in (0.0, float(np.clip(delay, -farthest, farthest)))]
        if expected.shape[1] <= MOST_ZONES and (told := _sources(light, excess, noise)):
            source, shift = told
            found.append({"source": source, "delay": float(np.clip(shift * width, -farthest, farthest))})
        return [{"share": self.parameter("share").start} | start for start in found]


def _sources(light: np.ndarray, excess: np.ndarray, noise: np.ndarray) -> tuple[np.ndarray, int] | None:
    """(P,) whose light each zone receives, by how many bins late, alike in all; None where none is told.

    light, excess, noise: (F, P, T), noise as one over the variance.
    """
    zones, bins = light.shape[1:]
    evidence = np.zeros((zones, zones, 2 * bins - 1))
    for zone in range(zones):
        promised = correlation(light, (excess * noise)[:, [zone]]).sum(axis=0)
        information = correlation(light**2, noise[:, [zone]]).sum(axis=0)
        evidence[zone] = np.where(information > 1, np.maximum(promised, 0) ** 2 / np.maximum(information, 1), 0)
        evidence[zone, zone] = 0
    best = np.maximum(evidence.max(axis=1) - TOLD, 0)
    shift = int(best.sum(axis=0).argmax())
    heard = best[:, shift] > 0
    source = np.where(heard, evidence[:, :, shift].argmax(axis=1), np.arange(zones))
    return (source.astype(float), shift - (bins - 1)) if heard.any() else None


def others(grid: tuple[int, int], of: int) -> tuple[np.ndarray, np.ndarray]:
    """(P,) zone whose light each zone of a grid of rows and columns receives, and (P,) whether there is one."""
    zone = np.arange(grid[0] * grid[1])
    if of in (BEFORE, AFTER):
        other = zone + (1 if of == AFTER else -1)
        return other % len(zone), (other >= 0) & (other < len(zone))
    row, column = np.divmod(zone, grid[1])
    row = row if of == SIDEWAYS else grid[0] - 1 - row
    column = column if of == UPSIDE_DOWN else grid[1] - 1 - column
    other = row * grid[1] + column
    return other, np.ones(len(zone), bool)


effect = ZoneGhost()
