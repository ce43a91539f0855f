"""The command line: the group of commands, and what a user sees of an error."""

from __future__ import annotations

import os
import sys
from importlib.metadata import version

import click

from conrod.cli import options as exit_status
from conrod.cli.ablate import ablate
from conrod.cli.audit import audit
from conrod.cli.export import export
from conrod.cli.harden import harden
from conrod.cli.limits import limits
from conrod.cli.lint import lint
from conrod.cli.recommend import recommend
from conrod.cli.results import results
from conrod.cli.show import show
from conrod.cli.sweep import sweep
from conrod.cli.validate import validate
from conrod.errors import InvalidInput

CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 110}


@click.group(context_settings=CONTEXT)
@click.version_option(version("conrod"), prog_name="conrod")
def cli() -> None:
    """Physics engines, cross-validated against mechanisms whose motion is known exactly."""


for command in (show, validate, sweep, recommend, limits, ablate, audit, lint, harden, results, export):
    cli.add_command(command)


def main() -> None:
    """Run the command line; a user's error is one line and exit status 2."""
    try:
        cli.main(standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
    except click.ClickException as error:
        _fail(error.format_message())
    except InvalidInput as error:
        _fail(str(error))
    except BrokenPipeError:
        # Whoever read the output has seen enough.
        _drop_output()
    except MemoryError:
        _fail("out of memory: fewer --steps-per-rev or --revolutions")
    except OSError as error:
        _drop_output()
        _fail(f"{error.strerror or error}: {error.filename}" if error.filename else str(error))
    except (KeyboardInterrupt, click.Abort):
        click.echo("conrod: interrupted", err=True)
        sys.exit(exit_status.INTERRUPTED)


def _drop_output() -> None:
    """Forget what standard output cannot take: Python would complain again when it closes the stream."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fail(message: str) -> None:
    click.echo(f"conrod: {' '.join(message.split())}", err=True)
    sys.exit(exit_status.USAGE)
