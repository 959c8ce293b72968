"""`difflidar info`: what a recording or a file of response maps holds."""

import json
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

LONGEST = 60


@click.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print the same as JSON and nothing else.")
def command(file, as_json):
    """Say what FILE, a recording or response maps, holds."""
    from recordings.describe import describe_maps, describe_recording
    from recordings.files import holds_maps, load
    from recordings.maps_file import load_maps

    said = describe_maps(load_maps(file)) if holds_maps(file) else describe_recording(load(file))
    if as_json:
        click.echo(json.dumps(said))
        return
    table = Table("", "", title=str(file), show_header=False)
    for name, value in rows(said):
        table.add_row(name, value)
    table.add_section()
    for name, field in said["fields"].items():
        shape = " x ".join(str(n) for n in field["shape"]) or "one value"
        table.add_row(name, f"{shape} {field['type']}, {size(field['bytes'])}")
    table.add_section()
    for name, value in said["meta"].items():
        text = value if isinstance(value, str) else json.dumps(value)
        table.add_row(name, text if len(text) <= LONGEST else f"{text[: LONGEST - 4]} ...")
    Console(markup=False).print(table)


def rows(said: dict) -> list[tuple[str, str]]:
    """The figures as a person reads them."""
    grid = " x ".join(str(n) for n in said["zone_grid"])
    common = [
        ("kind", said["kind"]),
        ("sensor", str(said["sensor"] or "not said")),
        ("zones", f"{said['zones']} ({grid})"),
    ]
    if said["kind"] == "recording":
        rate = said["rate_hz"]
        return [
            *common,
            ("bins", str(said["bins"])),
            ("bin width", f"{said['bin_width_ps']:.4g} ps, {said['bin_width_mm']:.4g} mm of range"),
            ("frames", f"{said['frames']} in {said['duration_s']:.4g} s" + (f", {rate:.4g} Hz" if rate else "")),
            ("absent", ", ".join(said["absent"]) or "nothing"),
        ]
    low_high = [f"{low:.1f} to {high:.1f}" for low, high in (said["extent_x_px"], said["extent_y_px"])]
    width, height = said["image_size"]
    missing = ", ".join(said["missing_for_space"])
    return [
        *common,
        ("positions", str(said["positions"])),
        ("extent", f"x {low_high[0]}, y {low_high[1]} px of {width} x {height}"),
        ("valid", f"in the image plane only ({missing} missing)" if missing else "in space, at any range"),
    ]


def size(count: int) -> str:
    """Bytes in the unit that fits."""
    for unit in ("B", "kB", "MB"):
        if count < 1000:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.3g} GB"
