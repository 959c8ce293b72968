"""`difflidar convert`: a recording of any known form becomes .rrd or .npz."""

import json
from pathlib import Path

import click

from difflidar.progress import bar


@click.command()
@click.argument("a", type=click.Path(path_type=Path))
@click.argument("b", type=click.Path(path_type=Path))
def command(a, b):
    """Convert recording A, .rrd, .npz or published data, to B, .rrd or .npz by its name.

    Where the published data say where each zone looks, that is written beside B as response maps.
    """
    from recordings.atomic import expect_place_for
    from recordings.files import maps_of, save, stream
    from recordings.maps_file import save_maps

    expect_place_for(b)
    passing, maps = stream(a), maps_of(a)
    save(passing, b, progress=bar)
    click.echo(f"wrote {b}")
    for note in notes(json.loads(passing.static.get("meta_json", "{}"))):
        click.echo(f"  {note}")
    if maps is not None:
        beside = b.with_name(f"{b.stem}.maps.npz")
        save_maps(maps, beside)
        click.echo(f"wrote {beside}: where each zone looks, as the data say")


def notes(meta: dict) -> list[str]:
    """What an importer had to assume or leave out: whoever uses the recording should know."""
    said = [f"assumed {assumption}" for assumption in meta.get("assumed", [])]
    if meta.get("truncated"):
        said.append("the file ends in the middle of a record; what was whole is here")
    for key, what in (
        ("records_left_out", "records could not be used"),
        ("missing_iters", "captures of the scan are missing"),
        ("duplicate_iters", "captures are there twice"),
    ):
        if meta.get(key):
            said.append(f"{len(meta[key])} {what}, listed in the meta as {key}")
    return said
