"""`difflidar demo`: a simulated patch scan, calibrated; a room, fused; a cause concealed in a recording, found."""

import sys
from pathlib import Path

import click
from rich.console import Console

from difflidar.progress import bar

LEAST = 160  # positions, of which a sixteenth still makes a map


@click.command()
@click.option("--out", default="out/demo", show_default=True, type=click.Path(path_type=Path), help="Folder to write.")
@click.option("--grid", default="80x45", show_default=True, metavar="COLUMNSxROWS", help="Positions of the scan.")
@click.option("--seed", default=0, show_default=True, help="Of everything random.")
def command(out, grid, seed):
    """Simulate a scan of a TMF8828, calibrate it, check it, show it; fuse a room; conceal a cause and find it."""
    import numpy as np

    from calibrate.calibration import calibrate
    from calibrate.consistency import cosines
    from calibrate.grid import map_images
    from calibrate.plan import ScanPlan
    from calibrate.simulated_scan import simulate_scan
    from calibrate.sparse import sparse_scans
    from calibrate.summary import summarise
    from difflidar.commands.calibrate import draw, show
    from difflidar.demo_concealed import conceal, find
    from difflidar.demo_fused import fuse_room
    from recordings.files import load, save
    from recordings.maps_file import save_maps
    from recordings.refusal import Refusal
    from viewers.curves import save_sparse_curve
    from viewers.scan_session import save_scan_session

    plan = ScanPlan.parse(grid)
    if plan.count < LEAST:
        raise Refusal(
            f"grid: {grid} has {plan.count} positions, expected {LEAST} or more to compare shorter scans with"
        )
    out.mkdir(parents=True, exist_ok=True)
    say = Console().print
    simulated = simulate_scan(plan, rng=np.random.default_rng(seed))
    save(simulated.patch, out / "scan.rrd", progress=bar)
    save(simulated.background, out / "background.rrd", progress=bar)

    scan, background = load(out / "scan.rrd"), load(out / "background.rrd")
    result = calibrate(scan, background, progress=bar)
    save_maps(result.maps, out / "maps.npz")
    show(result, 0.1, out / "maps.npz")

    cells = np.searchsorted(plan.frames[:, 0], result.positions.frames[:, 0])
    truth = simulated.truth
    off = np.hypot(*(np.stack([result.maps.xs, result.maps.ys], axis=1) - truth.centres_px[cells]).T)
    agree = cosines(result.maps.by_zone.astype(float), truth.blurred[:, cells])
    say(
        f"Held against the truth of the simulation: patch centres within {np.median(off):.2f} px (median) and "
        f"{np.quantile(off, 0.99):.2f} px (99 %), maps with cosine {agree.min():.4f} or more.",
        highlight=False,
        soft_wrap=True,
    )
    draw(out / "overlay.png", scan, result)
    total = len(result.maps.xs)
    shorter = sparse_scans(
        result.maps, result.positions.radius_px, tuple(total // n for n in (2, 4, 8, 16)), progress=bar
    )
    save_sparse_curve(out / "sparse.png", shorter)
    images = map_images(result.kernel, result.maps)
    save_scan_session(out / "session.rrd", scan, result, images, summarise(result, 0.1).sentences, bar)
    rms, held = fuse_room(out / "maps.npz", out, np.random.default_rng([seed, 2]), bar)
    say(
        f"\nA room, recorded with that sensor and fused through these maps: depth is off by {rms:.2f} m rms, and "
        f"{100 * held:.0f} % of pixels are within the interval that should hold 90 %.",
        highlight=False,
        soft_wrap=True,
    )
    cause = conceal(out / "maps.npz", out / "concealed.rrd", np.random.default_rng([seed, 1]))
    named = find(out / "maps.npz", out / "concealed.rrd", out / "explained")
    say(
        f"\nA recording in which {cause} was concealed: `difflidar explain` named {', '.join(named) or 'nothing'}; "
        f"see {out / 'explained' / 'report.html'}.",
        highlight=False,
        soft_wrap=True,
    )
    viewer = Path(sys.executable).with_name("rerun")
    say(
        f"\nIn {out}: overlay.png, sparse.png, maps.npz, scan.rrd, background.rrd, seen.rrd, fused, and two sessions "
        f"to look through:\n  {viewer} {out / 'session.rrd'}\n  {viewer} {out / 'fused.rrd'}",
        highlight=False,
        soft_wrap=True,
    )
