"""A far thing of limited extent, whose light is of the shot before: where it is, as an excess of counts tells."""

from collections.abc import Iterator
from itertools import product

import numpy as np
from scipy.constants import speed_of_light

from physics.far_wall import met, normal_of, planes, ways
from physics.marks import RIM, looked_at, received
from physics.motion import Motion
from physics.rendering import Rendering
from physics.replicas import DARK

# Half the size that fits begin with, as a part of the distance; middles lie as far apart as that, in directions that so
# many frames saw.
EXTENT, FRAMES = 0.2, 6
# Halved while that explains so many times as much, as what is small must, and not below this; where so much deviance
# is explained at all.
LIKELIER, SMALLEST, EXPLAINED = 1.05, 0.025, 20.0
# The same of a wall across all of the view.
ACROSS = 4.0
# Of the most that a board could show, what is too little to tell where it is; and what no division may meet.
TOLD, LEAST = 1e-3, 1e-12


def axes(toward: tuple[float, float]) -> np.ndarray:
    """(3, 3) rows: to the right, down and ahead of one who looks where azimuth and elevation, radians, say."""
    right, ahead = np.array([np.cos(toward[0]), 0, -np.sin(toward[0])]), normal_of(toward)
    return np.stack([right, np.cross(ahead, right), ahead])


def seen_board(
    rays: np.ndarray,
    toward: tuple[float, float],
    away_m: np.ndarray,
    extent: tuple[float, float],
    motion: Motion | None,
    time_s: np.ndarray,
    tilt: tuple[float, float] = (0.0, 0.0),
) -> tuple[np.ndarray, np.ndarray]:
    """(F, H, W) ranges, and what a white board sends back there, whatever the depth image holds.

    rays: (H, W, 3). toward: azimuth and elevation, radians, of its middle from where the session began, and away_m:
    (F,) metres to it. It faces that place but for its tilt, see `normal_of`. extent: half its width and height over the
    distance; its rim is as soft as a mark's. motion: of the camera, None where the board goes along with it.
    """
    ranges, sends = met(rays, *planes(normal_of(toward, tilt), away_m, motion, time_s))
    units = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    at = np.eye(4)[None] if motion is None else motion.start_from_camera[motion.nearest(time_s)]
    for axis, half in zip(axes(toward), extent, strict=False):
        along = np.einsum("hwk,fk->fhw", units, axis @ at[:, :3, :3]) * ranges + (at[:, :3, 3] @ axis)[:, None, None]
        outside = np.abs(along) / (half * away_m[:, None, None]) - 1
        sends = sends / (1 + np.exp(np.clip(outside / RIM, -60, 60)))
    return ranges, sends


def likely_boards(
    excess: np.ndarray, expected: np.ndarray, rendering: Rendering, period_s: float
) -> list[dict[str, float]]:
    """Boards that explain most of an excess (F, P, T): going along with the camera and, where it moves, standing.

    Seen before whatever depth images hold and, where they lack it somewhere, `hidden` by what they hold.
    """
    some, found = looked_at(rendering.light), []
    rays, known = rendering.light.rays[some[1:]], rendering.light.range_m[some] > 0
    for hidden, (still, motion) in product((0.0,) if known.all() else (0.0, 1.0), ways(rendering)):
        tried, board = [(toward, EXTENT) for toward in _directions(rays, motion)], None
        while tried:
            likelier = _likeliest(excess, expected, rendering, period_s, motion, tried, 1 - hidden * known)
            tried = []
            if likelier is not None and likelier[0] > LIKELIER * (board[0] if board else 0.0):
                board, tried = likelier, list(_parts(likelier[1])) if likelier[0] > EXPLAINED else []
        found += [] if board is None else [board[1] | {"still": still, "hidden": hidden}]
    return found


def _parts(board: dict[str, float]) -> Iterator[tuple[tuple[float, float], float]]:
    """Azimuths, elevations and half the size of boards half as large within and about a board."""
    half = board["wide"] / 2
    if half >= SMALLEST:
        for right, up in np.ndindex(5, 5):
            yield (board["azimuth"] + (right - 2) * half, board["elevation"] + (up - 2) * half), half


def likely_across(excess: np.ndarray, expected: np.ndarray, rendering: Rendering) -> list[dict[str, float]]:
    """The same of walls across all of the view, one period away that is as short as the window allows.

    Ranges differ the more from its middle to its rim the nearer a wall is.
    """
    period_s, found = rendering.clock.bins * rendering.clock.bin_width_s, []
    for still, motion in ways(rendering):
        wall = _likeliest(excess, expected, rendering, period_s, motion, [((0.0, 0.0), ACROSS)])
        found += [] if wall is None else [{"depth": wall[1]["depth"], "period": period_s, "still": still}]
    return found


def _likeliest(
    excess: np.ndarray,
    expected: np.ndarray,
    rendering: Rendering,
    period_s: float,
    motion: Motion | None,
    tried: list[tuple[tuple[float, float], float]],
    seen: np.ndarray | float = 1.0,
) -> tuple[float, dict[str, float]] | None:
    """The deviance and the board one period, seconds, away that explains most of an excess (F, P, T); None: none would.

    tried: directions, azimuth and elevation, and half of the size over the distance. seen: part (F, H, W) of it that
    pixels `looked_at` see.

    Matched filters for white noise (Turin 1960, IRE Trans. Inf. Theory 6, 311) at all whole bins: of the pulse, where
    the way to the board puts it in each frame, and of what each zone sees of it.
    """
    clock, light, some = rendering.clock, rendering.light, looked_at(rendering.light)
    noise, bins, bin_m = 1 / np.maximum(expected, DARK), clock.bins, speed_of_light / 2 * clock.bin_width_s
    pulses = clock.pulse.in_bins((np.arange(bins) + 0.5) * clock.bin_width_s, bins, clock.bin_width_s)
    amiss, told = (excess * noise) @ pulses.T, noise @ (pulses**2).T
    zero = np.broadcast_to(clock.time_zero_s, expected.shape[:2]) / clock.bin_width_s
    rays = light.rays[some[1:]]
    away_m = np.full(light.frames, speed_of_light / 2 * period_s)
    best, found = 0.0, None
    for toward, half in tried:
        there = seen_board(rays, toward, away_m, (half, half), motion, light.time_s)[1]
        share = received(there * seen, rendering.footprints.weights[some])
        # Which bin of each frame and zone light comes in from as many bins farther than the period reaches.
        nearer_m = away_m - planes(normal_of(toward), away_m, motion, light.time_s)[1]
        first = np.rint(zero - (nearer_m / bin_m)[:, None]).astype(int)
        come = np.arange(bins) + first[..., None]
        share = share[..., None] * ((come >= 0) & (come < bins))
        come = np.clip(come, 0, bins - 1)
        promised = (share * np.take_along_axis(amiss, come, -1)).sum(axis=(0, 1))
        information = (share**2 * np.take_along_axis(told, come, -1)).sum(axis=(0, 1))
        evidence = np.maximum(promised, 0) ** 2 / np.maximum(information, TOLD * information.max() + LEAST)
        later = int(np.argmax(evidence))
        if evidence[later] > best:
            place = {"depth": float(away_m[0] + later * bin_m), "azimuth": toward[0], "elevation": toward[1]}
            best, found = float(evidence[later]), place | {"wide": half, "high": half}
    return None if found is None else (best, found)


def _directions(rays: np.ndarray, motion: Motion | None) -> Iterator[tuple[float, float]]:
    """Azimuths and elevations spread over what some frames saw."""
    turned = np.eye(3)[None] if motion is None else motion.start_from_camera[:, :3, :3]
    few = turned[np.unique(np.linspace(0, len(turned) - 1, FRAMES).astype(int))]
    x, y, z = np.moveaxis(np.einsum("fij,hwj->fhwi", few, rays).reshape(-1, 3), -1, 0)
    angles = np.stack([np.arctan2(x, z), -np.arctan2(y, np.hypot(x, z))], axis=-1)
    for azimuth, elevation in (np.unique(np.floor(angles / EXTENT).astype(int), axis=0) + 0.5) * EXTENT:
        yield float(azimuth), float(elevation)
