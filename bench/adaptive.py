"""How many positions an adaptive scan needs for the cosine to the full map that evenly spread ones reach.

Evenly spread positions are completed twice: by splines, and as adaptive scans are, by the sensor's optics.

Run with the names of what to measure: long, short (the published maps), and whole numbers (simulated sensors). The
plan was made with the long-range maps and sensors 1 to 3 and 6; the short-range maps and other sensors test it.
"""

import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from calibrate.adaptive import COARSE, LIT, AdaptivePlan
from calibrate.adaptive_fill import filled
from calibrate.consistency import cosines
from calibrate.kernel import PUBLISHED_RADIUS_PX, fit_kernel
from calibrate.plan import ScanPlan
from calibrate.simulated.bench import Bench
from calibrate.simulated.disc import from_discs
from calibrate.sparse import spread_order
from physics.optics import tmf882x_optics
from recordings.maps import ResponseMaps
from recordings.maps_file import load_maps

EVEN = (100, 150, 200, 250, 300, 350, 400, 450, 500, 550, 600, 700, 800, 900, 1000, 1200, 1500, 1800)
LEVELS = (0.97, 0.98, 0.99, 0.995)
EVEN_FILLED = (60, 80, 100, 150, 200, 300, 450)
MOST = 400
FILES = {"long": "spad_calib_3x3_longrange_bins15_35.npz", "short": "spad_calib_3x3_shortrange_bins45_75.npz"}


def published(name: str) -> ResponseMaps:
    """The published maps of one range mode."""
    root = Path(os.environ.get("DIFFLIDAR_DATA", Path(__file__).parents[1] / ".." / "shared" / "data"))
    path = root / "tmf8828_response_maps" / FILES[name]
    if not path.is_file():
        sys.exit(f"the published maps are not at {path}; set DIFFLIDAR_DATA to where the data are")
    return load_maps(path)


def simulated(seed: int) -> ResponseMaps:
    """Maps of one sensor that the plan's nominal one is not: turned, with other texture, blur, areas and dead SPADs."""
    rng = np.random.default_rng(seed)
    optics = tmf882x_optics(6, rng)
    dead = rng.random(optics.spads.masks.shape) < 0.03
    flood = replace(optics.flood, half_width_deg=optics.flood.half_width_deg * rng.uniform(0.85, 1.15, 2))
    optics = replace(
        optics,
        spads=replace(optics.spads, masks=optics.spads.masks & ~dead),
        flood=flood,
        active_m=tuple(np.array(optics.active_m) * rng.uniform(0.85, 1.05, 2)),
        blur_m=optics.blur_m * rng.uniform(0.7, 2),
        halo_share=rng.uniform(0, 0.15),
        stray_share=rng.uniform(0, 0.03),
    )
    bench = Bench(lidar_rotation_deg=tuple(rng.normal(0, (3, 3, 8))), tilt_deg=tuple(rng.normal(0, 2, 2)))
    positions = bench.patch_positions(ScanPlan(80, 45), rng)
    maps = 3e6 * from_discs(optics, bench, positions)
    maps /= maps.max() / 3e6
    maps = rng.poisson(maps * rng.normal(1, 0.005, maps.shape[1]))
    pixels = bench.project(positions) + rng.normal(0, 0.2, (len(positions), 2))
    names = np.array([f"{i:04d}" for i in range(len(positions))])
    return ResponseMaps(maps.reshape(3, 3, -1).astype(np.float32), *pixels.T, names)


def evenly(maps: ResponseMaps) -> list[tuple[int, float, float, float]]:
    """Points, worst and mean cosine (and no estimate) of the kernel through evenly spread positions."""
    x, y = maps.xs.astype(float), maps.ys.astype(float)
    order = spread_order(np.stack([x, y], axis=1), max(EVEN))
    found = []
    for n in EVEN:
        value = fit_kernel(maps, PUBLISHED_RADIUS_PX, np.sort(order[:n])).response(x, y)
        value[:, order[:n]] = maps.by_zone[:, order[:n]]
        cosine = cosines(maps.by_zone.astype(float), value)
        found.append((n, float(cosine.min()), float(cosine.mean()), np.nan))
    return found


def evenly_filled(maps: ResponseMaps) -> list[tuple[int, float, float, float]]:
    """The same of what the optics' model makes of evenly spread positions."""
    field = np.stack([maps.xs, maps.ys], axis=1).astype(float)
    order, full, found = spread_order(field, max(EVEN_FILLED)), maps.by_zone.astype(float), []
    for n in EVEN_FILLED:
        some = order[:n]
        part = replace(
            maps, responses=maps.responses[..., some], xs=maps.xs[some], ys=maps.ys[some], cap_ids=maps.cap_ids[some]
        )
        predicted = filled(part, field, PUBLISHED_RADIUS_PX)
        value = full.copy()
        value[:, [int(name[1:]) for name in predicted.cap_ids[n:]]] = predicted.by_zone[:, n:]
        cosine = cosines(full, value)
        found.append((n, float(cosine.min()), float(cosine.mean()), np.nan))
    return found


def adaptively(maps: ResponseMaps, prior: ResponseMaps | None = None) -> list[tuple[int, float, float, float]]:
    """Points, worst and mean cosine, and the worst as the plan estimated it (0 before that counts), batch by batch."""
    plan = AdaptivePlan(
        np.stack([maps.xs, maps.ys], axis=1), PUBLISHED_RADIUS_PX, accuracy=0.9999, most=MOST, prior=prior
    )
    full, taken, found = maps.by_zone.astype(float), 0, []
    while len(cells := plan.next()):
        plan.learn(cells, full[:, cells])
        taken += len(cells)
        if taken > COARSE + LIT:
            cosine = cosines(full, plan.expected())
            found.append((taken, float(cosine.min()), float(cosine.mean()), plan.reached))
    return found


def needed(curve: list[tuple[int, float, float, float]], level: float, column: int = 1) -> float:
    """Points at which a curve first reaches the cosine, between two of its points by the error's logarithm."""
    before = None
    for here in curve:
        if here[column] >= level:
            if before is None:
                return here[0]
            error = [np.log(1 - c) for c in (before[column], here[column], level)]
            return before[0] + (here[0] - before[0]) * (error[2] - error[0]) / (error[1] - error[0])
        before = here
    return np.nan


def main(names: list[str]) -> None:
    """Print the tables."""
    for name in names:
        prior = None
        if "+" in name:
            name, other = name.split("+")
            prior = published(other)
        maps = published(name) if name in FILES else simulated(int(name))
        adaptive = adaptively(maps, prior)
        print(f"\n{name}{' with the other mode as prior' if prior else ''}")
        print("adaptive: points, worst cosine (estimated), mean")
        for n, worst, mean, estimate in adaptive:
            print(f"{n:6} {worst:.4f} ({estimate:.4f}) {mean:.4f}", flush=True)
        for way, evenly_completed in (("splines", evenly), ("optics", evenly_filled)):
            curve = evenly_completed(maps)
            print(f"even, {way}: points, worst cosine, mean")
            for n, worst, mean, _ in curve:
                print(f"{n:6} {worst:.4f} {mean:.4f}")
            for title, column in (("worst", 1), ("mean", 2)):
                for level in LEVELS:
                    few, many = needed(adaptive, level, column), needed(curve, level, column)
                    ratio = few / many
                    print(f"{title} cosine {level}: adaptive {few:.0f}, even {many:.0f}, ratio {ratio:.2f}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or ["long", "short", "4", "5"])
