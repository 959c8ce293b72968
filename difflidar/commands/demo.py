"""`difflidar demo`: a rehearsed patch scan, calibrated; a room, fused; a cause concealed in a recording, found."""

import sys
from pathlib import Path

import click
from rich.console import Console

from difflidar.progress import bar

LEAST = 160


@click.command()
@click.option("--out", default="out/demo", show_default=True, type=click.Path(path_type=Path), help="Folder to write.")
@click.option("--grid", default="80x45", show_default=True, metavar="COLUMNSxROWS", help="Positions of the scan.")
@click.option("--seed", default=0, show_default=True, help="Of everything random.")
def command(out, grid, seed):
    """Rehearse a scan of a TMF8828 and calibrate it; fuse a room through its maps; conceal a cause and find it."""
    import numpy as np

    from calibrate.calibration import calibrate
    from calibrate.grid import map_images
    from calibrate.plan import ScanPlan
    from calibrate.summary import summarise
    from difflidar.commands.calibrate import draw, show
    from difflidar.demo_concealed import conceal, find
    from difflidar.demo_fused import fuse_room
    from difflidar.demo_rehearsed import against_truth, scan_rehearsed
    from difflidar.scan_progress import ScanProgress
    from recordings.files import load
    from recordings.maps_file import save_maps
    from recordings.refusal import Refusal
    from viewers.scan_session import save_scan_session

    plan = ScanPlan.parse(grid)
    if plan.count < LEAST:
        raise Refusal(f"grid: {grid} has {plan.count} positions, expected {LEAST} or more for an adaptive scan")
    out.mkdir(parents=True, exist_ok=True)
    say = Console().print
    with ScanProgress() as shown:
        written, tally = scan_rehearsed(out, grid, seed, shown.tell, shown.saw)
    scan, background = load(written["patch"]), load(written["background"])
    say(
        f"An arm that is not there moved a patch before a sensor and a camera that are not there: {len(scan.counts)} "
        f"of {plan.count} positions were enough, in {tally['whole_s']:.0f} s.",
        highlight=False,
        soft_wrap=True,
    )
    result = calibrate(scan, background, progress=bar)
    save_maps(result.maps, out / "maps.npz")
    show(result, 0.1, out / "maps.npz")
    off, agree = against_truth(result, grid, seed)
    say(
        f"Held against the truth of the rehearsal: patch centres within {np.median(off):.2f} px (median) and "
        f"{np.quantile(off, 0.99):.2f} px (99 %), maps over all {plan.count} positions with cosine {agree.min():.4f} "
        "or more.",
        highlight=False,
        soft_wrap=True,
    )
    draw(out / "overlay.png", scan, result)
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
        f"\nIn {out}: overlay.png, maps.npz, scan.rrd, scan-background.rrd, seen.rrd, fused, and two sessions "
        f"to look through:\n  {viewer} {out / 'session.rrd'}\n  {viewer} {out / 'fused.rrd'}",
        highlight=False,
        soft_wrap=True,
    )
