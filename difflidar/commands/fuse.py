"""`difflidar fuse`: histograms and images become depth, clouds, and one mesh of all frames."""

from pathlib import Path

import click

from difflidar.progress import bar


@click.command()
@click.argument("recording", type=click.Path(path_type=Path))
@click.option("--calibration", "maps_path", required=True, type=click.Path(path_type=Path), help="Response maps, .npz.")
@click.option("--sensor", "sensor_name", help="A sensor.json, or a preset; default: as recorded.")
@click.option("--method", help="How depth is found; default: the best there is.")
@click.option("--alone", is_flag=True, help="Take each frame by itself: earlier images and poses tell nothing.")
@click.option("--voxel", default=0.04, show_default=True, help="Edge of the voxels of the mesh, metres.")
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder to write.")
def command(recording, maps_path, sensor_name, method, alone, voxel, out):
    """Fuse RECORDING into depth for every pixel of its camera, and into point clouds.

    Zones look where the response maps say. Of every frame OUT receives depth, its uncertainty, confidence, the zone
    that contributes most, and a cloud; of all frames, a mesh and a cloud, where poses were recorded or follow from
    odometry.
    """
    from fusion.fuse import METHODS, expect_method
    from fusion.rig import open_rig
    from fusion.save import expect_folder_for, folder_aside
    from fusion.session import fuse_into
    from recordings.maps_file import load_maps

    method = method or METHODS[-1]
    expect_method(method)
    expect_folder_for(out)
    maps = load_maps(maps_path)
    passing, sight, response = open_rig(recording, maps, sensor_name)
    names = {"recording": recording.name, "calibration": maps_path.name}
    with folder_aside(out) as folder:
        said = fuse_into(
            folder, passing, sight, response, method, alone=alone, voxel_m=voxel, names=names, progress=bar
        )
    click.echo(f"wrote {out}: {len(said['frames'])} frames by {method}")
    for sentence in said["sentences"]:
        click.echo(sentence)
