"""`difflidar repair`: what is whole of an interrupted recording becomes a recording."""

from pathlib import Path

import click

from difflidar.progress import bar


@click.command()
@click.argument("broken", type=click.Path(path_type=Path))
@click.argument("out", type=click.Path(path_type=Path))
def command(broken, out):
    """Save the whole frames of BROKEN, an .rrd that was cut off or the .partial of one, to OUT.rrd."""
    from recordings.rrd.repair import repair

    found = repair(broken, out, progress=bar)
    click.echo(f"wrote {out}: {found.frames} frames recovered")
    if found.incomplete:
        some = ", ".join(str(frame) for frame in found.incomplete[:10])
        more = " ..." if len(found.incomplete) > 10 else ""
        click.echo(f"lost: {len(found.incomplete)} frames that are not whole ({some}{more})")
    if found.fields:
        click.echo(f"lost: {', '.join(found.fields)}, damaged")
    if found.damaged_messages:
        click.echo(f"lost: {found.damaged_messages} damaged parts of the file")
    if found.cut_bytes:
        click.echo(f"lost: the last {found.cut_bytes} bytes, in which writing was cut off")
