"""`difflidar calibrate`: a patch scan becomes response maps."""

from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from difflidar.options import Numbers
from difflidar.progress import bar


@click.command()
@click.argument("scan", type=click.Path(path_type=Path))
@click.option("--background", type=click.Path(path_type=Path), help="The same captures without the patch.")
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Maps to write, .npz.")
@click.option("--grid", metavar="COLUMNSxROWS", help="Grid of the scan, such as 80x45; default: as recorded.")
@click.option("--window", type=Numbers(int, 2, ":"), help="First and last bin of G; default: chosen from the data.")
@click.option("--patch-radius", type=float, metavar="PX", help="Radius of the patch; default: found in the frames.")
@click.option("--patch-distance", type=float, metavar="M", help="Distance of the patch's plane along the optical axis.")
@click.option("--baseline", type=Numbers(float, 3, ","), metavar="X,Y,Z", help="LiDAR in the camera's frame, metres.")
@click.option("--rig", type=click.Path(path_type=Path), help="rig.json: where the LiDAR and the patch's plane are.")
@click.option("--threshold", default=0.1, show_default=True, help="Fraction of the peak that bounds a support.")
@click.option("--picture", type=click.Path(path_type=Path), help="Overlay of the maps on the camera image, .png.")
def command(scan, background, out, grid, window, patch_radius, patch_distance, baseline, rig, threshold, picture):
    """Turn SCAN, a recording of a patch moved through the field, into response maps.

    Maps are put into space where the camera's intrinsics, the LiDAR's place and the patch's distance are known: from
    the options, from the rig file, or from what the recording says, in this order.
    """
    from dataclasses import replace

    from calibrate.calibration import calibrate
    from calibrate.plan import ScanPlan
    from calibrate.rig import load_rig
    from recordings.atomic import expect_place_for
    from recordings.files import load
    from recordings.maps_file import save_maps
    from recordings.refusal import Refusal

    for path in (out, picture):
        if path is not None:
            expect_place_for(path)
    if not 0 < threshold < 1:
        raise Refusal(f"threshold: {threshold} found, expected a fraction of the peak between 0 and 1")
    known = None if rig is None else load_rig(rig)
    recording = load(scan)
    if known is not None:
        recording = replace(recording, lidar_from_camera=known.lidar_from_camera)
        patch_distance = known.patch_distance_m if patch_distance is None else patch_distance
    result = calibrate(
        recording,
        None if background is None else load(background),
        plan=None if grid is None else ScanPlan.parse(grid),
        window=window,
        patch_radius_px=patch_radius,
        patch_depth_m=patch_distance,
        baseline_m=baseline,
        progress=bar,
    )
    save_maps(result.maps, out)
    if picture is not None:
        draw(picture, recording, result)
    show(result, threshold, out)


def draw(picture: Path, recording, result) -> None:
    """Write the overlay of the maps on the camera image in which the patch was nearest the middle."""
    import numpy as np

    from calibrate.grid import map_images
    from recordings.refusal import Refusal
    from viewers.overlay import save_overlay

    if result.kernel is None or recording.rgb is None:
        raise Refusal(f"{picture}: an overlay needs camera frames and 10 scan positions; the maps were written")
    maps = result.maps
    seen = np.stack([result.positions.x_px, result.positions.y_px], axis=1)
    middle = np.hypot(*(seen - np.array(maps.image_size) / 2).T).argmin()
    frame = int(result.positions.frames[middle, 0])
    save_overlay(picture, recording.rgb[frame], map_images(result.kernel, maps), maps.zone_grid)


def show(result, threshold: float, out: Path) -> None:
    """Say what was found: where the patch was seen, the window, and each zone's map."""
    from calibrate.summary import summarise

    said = summarise(result, threshold)
    console = Console()
    table = Table(title=str(out))
    for heading in ("zone", "peak", "± peak", "noise", "support px²", "centroid px", "flagged"):
        table.add_column(heading, no_wrap=True, justify="right")
    for zone in said.zones:
        table.add_row(
            f"{zone.row},{zone.column}",
            f"{zone.peak:,.0f}",
            f"{zone.peak_sigma:,.0f}",
            f"{zone.noise:,.0f}",
            f"{zone.support_px2:,.0f}",
            f"{zone.centroid_px[0]:.1f} {zone.centroid_px[1]:.1f}",
            str(zone.flagged),
        )
    console.print(table)
    for sentence in said.sentences:
        console.print(sentence, highlight=False, soft_wrap=True)
