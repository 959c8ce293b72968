"""The `difflidar` command: finds its commands, and turns every refusal into one sentence and exit status 2."""

import errno
import importlib
import os
import pkgutil
import sys
from collections.abc import Sequence

import click

import difflidar.commands
from recordings.refusal import Refusal


class Commands(click.Group):
    """One command a file in `difflidar/commands`; a command's libraries load only when it runs."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of the commands, which are the names of their files."""
        return sorted(module.name for module in pkgutil.iter_modules(difflidar.commands.__path__))

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Load the command `name`, or None where there is none."""
        if name not in self.list_commands(ctx):
            return None
        return importlib.import_module(f"difflidar.commands.{name}").command


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="difflidar")
def difflidar_command() -> None:
    """Calibrate, fuse, record and explain diffuse LiDARs beside an RGB camera."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line; exits with 0, or with 2 after one sentence on standard error."""
    try:
        status = difflidar_command.main(args=arguments, prog_name="difflidar", standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as help_page:
        click.echo(help_page.ctx.get_help())
        sys.exit(2)
    except click.ClickException as wrong:
        refuse(wrong.format_message())
    except click.Abort:
        refuse("interrupted; nothing was written")
    except (Refusal, MemoryError) as wrong:
        refuse(str(wrong) or "not enough memory for this input")
    except BrokenPipeError:
        # Whoever read the output, such as `head`, has seen enough; nothing must be written at exit, either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except OSError as wrong:
        refuse(operating_system_says(wrong))
    sys.exit(status if isinstance(status, int) else 0)


def refuse(sentence: str) -> None:
    """Print one sentence on standard error and exit with status 2."""
    print(f"difflidar: {' '.join(sentence.split())}", file=sys.stderr)
    sys.exit(2)


def operating_system_says(wrong: OSError) -> str:
    """The operating system's refusal as a sentence that names the file and what to do."""
    place = wrong.filename or "the output"
    advice = {
        errno.ENOSPC: "the disk is full; nothing was written",
        errno.EDQUOT: "the disk quota is used up; nothing was written",
        errno.EFBIG: "larger than files may be here; nothing was written",
        errno.EACCES: "no permission",
        errno.ENOENT: "no such file",
        errno.EROFS: "the file system is read-only",
        errno.EISDIR: "is a folder, expected a file",
    }
    return f"{place}: {advice.get(wrong.errno, wrong.strerror or str(wrong))}"
