"""`difflidar baseline`: where the LiDAR sits beside the camera, from two scans at different ranges."""

from pathlib import Path

import click

from difflidar.options import Numbers
from difflidar.progress import bar


@click.command()
@click.argument("a", type=click.Path(path_type=Path))
@click.argument("b", type=click.Path(path_type=Path))
@click.option("--distances", required=True, type=Numbers(float, 2, ","), metavar="A,B", help="Patch planes, metres.")
@click.option("--intrinsics", required=True, type=Numbers(float, 4, ","), metavar="FX,FY,CX,CY", help="Of the camera.")
@click.option("--patch-radii", type=Numbers(float, 2, ","), metavar="A,B", help="In pixels; default: as calibrated.")
def command(a, b, distances, intrinsics, patch_radii):
    """Estimate the LiDAR's position in the camera's frame from maps A and B taken at two distances."""
    import numpy as np

    from calibrate.baseline import estimate_baseline
    from recordings.maps_file import load_maps
    from recordings.refusal import Refusal

    maps = load_maps(a), load_maps(b)
    fx, fy, cx, cy = intrinsics
    radii = patch_radii or tuple(m.meta.get("patch_radius_px") for m in maps)
    if None in radii:
        raise Refusal("patch_radius_px: not in the meta of the maps, expected --patch-radii A,B in pixels")
    found = estimate_baseline(*maps, np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]), distances, radii, bar)
    for axis, value, sigma in zip("xyz", found.origin_m * 1e3, found.sigma_m * 1e3, strict=True):
        click.echo(f"{axis} {value:+.2f} ± {sigma:.2f} mm")
    click.echo(
        f"maps agree within {found.rms:.3f} of the peak (rms); --baseline "
        + ",".join(f"{v:.5f}" for v in found.origin_m)
    )
