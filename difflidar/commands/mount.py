"""`difflidar mount`: the parts to print for a rig, and their drawing."""

from pathlib import Path

import click


def show_example(ctx: click.Context, param: click.Parameter, wanted: bool) -> None:
    """Print a rig file that says everything, and end."""
    if not wanted or ctx.resilient_parsing:
        return
    from dataclasses import asdict, replace

    from calibrate.rig import Rig
    from devices.parts.holder import Holder
    from devices.parts.measures import Measures

    rig = Rig()
    arm = replace(rig.arm, tool=Holder.of(rig).tool())
    click.echo(replace(rig, arm=arm, mount=asdict(Measures())).text(), nl=False)
    ctx.exit()


@click.command()
@click.argument("rig", type=click.Path(path_type=Path))
@click.option("--out", required=True, type=click.Path(path_type=Path), help="Folder to write to.")
@click.option(
    "--example", is_flag=True, is_eager=True, expose_value=False, callback=show_example, help="Print a rig file."
)
def command(rig, out):
    """Draw what holds the devices of RIG, a rig.json: files to print, and a drawing.

    A bracket for camera and LiDAR, and a holder for the patch on the arm's flange. Every measure has a name and can be
    set in the rig file under "mount"; --example prints a file with all of them.
    """
    from calibrate.rig import load_rig
    from devices.parts.bracket import Bracket
    from devices.parts.clear import expect_clear, expect_in_reach, expect_printable
    from devices.parts.holder import Holder
    from devices.parts.placed import Placed
    from recordings.refusal import Refusal
    from viewers.mount_drawing import save_drawing

    said = load_rig(rig)
    placed = Placed.of(said)
    expect_in_reach(placed)
    bracket, holder = Bracket(placed), Holder.of(said)
    parts = [bracket.part, holder.column, holder.front, holder.cover]
    expect_clear(bracket, parts[0])
    for part in parts:
        expect_printable(part, placed.measures.bed)
    if not out.absolute().parent.is_dir():
        raise Refusal(f"{out}: the folder {out.absolute().parent} does not exist")
    if out.is_file():
        raise Refusal(f"{out}: is a file, expected a folder, or a name for one")
    out.mkdir(exist_ok=True)
    x, y, z = placed.position
    notes = [f"LiDAR from the camera's colour lens: x {x:g}, y {y:g}, z {z:g}", *bracket.screws, parts[0].note]
    save_drawing(out / "drawing.pdf", bracket, parts[0], holder, notes)
    for part in parts:
        path = part.save(out)
        size = " x ".join(f"{side:.1f}" for side in part.size)
        click.echo(f"{path}: {size} mm, {part.solid.volume() / 1e3:.0f} cm³; {part.note}")
    click.echo(f"{out / 'drawing.pdf'}: full size on two sheets of A3")
    for sentence in bracket.screws:
        click.echo(sentence)
    click.echo(holder.mismatch(said) or f"patch {holder.length:g} mm before the flange, as arm.tool says")
