"""`difflidar grid`: the continuous maps as images, with their errors and supports."""

from pathlib import Path

import click

from difflidar.progress import bar


@click.command()
@click.argument("maps", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Images to write, .npz.")
@click.option("--step", default=4, show_default=True, help="Full-size pixels to a pixel of the images.")
@click.option("--patch-radius", type=float, metavar="PX", help="Radius of the patch; default: as calibrated, or 17.75.")
@click.option("--deconvolved", is_flag=True, help="Freed of the patch's size, rather than as the patch sees it.")
@click.option("--threshold", default=0.1, show_default=True, help="Fraction of the peak that bounds a support.")
def command(maps, out, step, patch_radius, deconvolved, threshold):
    """Write every zone's map over the image: response, its standard error, and where it reaches the threshold.

    Between and beside the scan points the map is that of the kernel fitted to them, so that a scan of few points gives
    whole maps, too, with errors that say how far they carry.
    """
    import numpy as np

    from calibrate.grid import map_images, sigma_images
    from calibrate.kernel import fit_kernel, patch_radius_of
    from recordings.atomic import expect_place_for, written_aside
    from recordings.maps_file import load_maps
    from recordings.refusal import Refusal

    expect_place_for(out)
    if not 0 < threshold < 1:
        raise Refusal(f"threshold: {threshold} found, expected a fraction of the peak between 0 and 1")
    found = load_maps(maps)
    kernel = fit_kernel(found, patch_radius_of(found) if patch_radius is None else patch_radius)
    response = map_images(kernel, found, step, deconvolved)
    sigma = sigma_images(kernel, found, step, deconvolved, bar)
    peak = np.nanmax(response, axis=(1, 2), keepdims=True)
    support = np.nan_to_num(response) >= threshold * np.where(peak > 0, peak, np.inf)
    shape = (*found.zone_grid, *response.shape[1:])
    with written_aside(out) as aside, aside.open("wb") as file:
        np.savez_compressed(
            file,
            response=response.reshape(shape).astype(np.float32),
            sigma=sigma.reshape(shape).astype(np.float32),
            support=support.reshape(shape),
            threshold=threshold,
            step_px=step,
            image_size=np.array(found.image_size),
        )
    error = np.nanmedian((sigma / peak)[support])
    click.echo(
        f"{out}: {shape[0]} x {shape[1]} zones, {shape[3]} x {shape[2]} pixels of {step} px; inside the supports"
    )
    click.echo(f"  the error is {error:.1%} of the peak (median); NaN where nothing was scanned")
