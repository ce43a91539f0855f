"""The command line: the group of commands, their help, what a user sees of an error, and messages in passing."""

from __future__ import annotations

import os
import signal
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from io import TextIOWrapper
from typing import Any

import click

from conrod import ONE_THREAD, SAFE_PATH
from conrod.crash import INTERRUPTED, USAGE, OutputClosed, discard_output, out_of_memory
from conrod.errors import InvalidInput, unknown_choice
from conrod.report.table import one_line, visible_text
from conrod.slices import SLICES

FAILED = 1  # exit status: out of tolerance, and nothing else; the others are in `conrod.crash`
COMPLETION = "_CONROD_COMPLETE"  # set by a shell that completes a line
CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 110}


# Verbs that no slice adds, with the line that `conrod --help` shows, and the module of each.
FIRST_VERBS = {"show": "List what there is, one line each; or describe one SCENE."}
LAST_VERBS = {
    "engines": "List the engines, what each can do, and where it comes from.",
    "report": "Render a folder's reports again from their own JSON.",
    "results": "Write the ledger of all runs as a table.",
}
VERBS = FIRST_VERBS | {verb: text for one in SLICES for verb, text in one.verbs.items()} | LAST_VERBS
MODULE_OF_VERB = {verb: f"{one.package}.verb" for one in SLICES for verb in one.verbs} | {
    "show": "conrod.cli.show", "engines": "conrod.cli.show", "report": "conrod.cli.report",
    "results": "conrod.cli.report",
}  # fmt: skip


@contextmanager
def _raise_output_closed() -> Iterator[None]:
    """Turn a broken pipe into `OutputClosed`, which click does not handle itself."""
    try:
        yield
    except BrokenPipeError:
        raise OutputClosed from None


class Verbs(click.Group):
    """A group whose commands are imported when they are called."""

    def make_context(self, *arguments: Any, **more: Any) -> click.Context:
        with _raise_output_closed():
            return super().make_context(*arguments, **more)

    def invoke(self, ctx: click.Context) -> Any:
        with _raise_output_closed():
            return super().invoke(ctx)

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in VERBS:
            if ctx.resilient_parsing:
                return None  # a shell that completes a line asks, and wants no error
            raise unknown_choice("command", cmd_name, VERBS, "conrod --help")
        command: click.Command = getattr(import_module(MODULE_OF_VERB[cmd_name]), cmd_name)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(VERBS.items()))


@click.group(cls=Verbs, context_settings=CONTEXT)
@click.version_option(package_name="conrod", prog_name="conrod")
def cli() -> None:
    """Physics engines, cross-validated against mechanisms whose motion is known exactly."""


def main() -> None:
    """Run the command line; a user's error is one line and exit status 2, any other error is raised."""
    _prepare()
    if COMPLETION in os.environ:
        import_module("conrod.cli.bash_completion")
    try:
        with _warnings_as_lines():
            cli.main(prog_name="conrod", standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
    except click.ClickException as error:
        _exit_with_error(error.format_message())
    except InvalidInput as error:
        _exit_with_error(str(error))
    except OutputClosed:
        # Whoever read the output has seen enough, and maybe not the verdict.
        discard_output(sys.stdout)
        raise
    except MemoryError:
        _exit_with_error(out_of_memory())
    except ImportError as error:
        if NO_ROOM not in str(error):
            raise
        _exit_with_error("out of memory: a library finds no room in the address space that is allowed here (ulimit -v)")
    except OSError as error:
        _drop_output()
        _exit_with_error(f"{error.strerror or error}: {error.filename}" if error.filename else str(error))
    except (KeyboardInterrupt, click.Abort):
        click.echo("conrod: interrupted", err=True)
        sys.exit(INTERRUPTED)


@contextmanager
def _warnings_as_lines() -> Iterator[None]:
    """Print each warning of the API as a line, even if Python is set to ignore or raise warnings."""
    with warnings.catch_warnings():
        warnings.filterwarnings("always", category=UserWarning, module=r"conrod\.")
        warnings.showwarning = _say_warning
        yield


def _say_warning(message: Warning | str, category: type[Warning], *place: object, **more: object) -> None:
    """Print a warning of the API as one line; warnings of libraries are for developers."""
    if category.__module__.startswith("conrod."):
        say(f"conrod: {one_line(str(message))}", err=True)


def _prepare() -> None:
    """Prepare the process: streams that any locale can print to, SIGTERM as Ctrl-C, one thread, a safe import path."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            # A locale without "²" shows the rest; lines end alike on all systems, for a table may be read by others.
            stream.reconfigure(errors="replace", newline="\n")
    # What a batch system or `timeout` sends ends it as Ctrl-C does: with what is under way undone.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    os.environ.update({**ONE_THREAD, **os.environ, **SAFE_PATH})


def _drop_output() -> None:
    """Forget what standard output cannot take: Python would complain again when it closes the stream."""
    try:
        sys.stdout.flush()
    except OSError:
        discard_output(sys.stdout)


def _exit_with_error(message: str) -> None:
    """Print an error as one line, and exit with `USAGE`, which is no verdict."""
    click.echo(f"conrod: {one_line(message)}", err=True)
    sys.exit(USAGE)


NO_ROOM = "failed to map segment"  # as the dynamic linker says of a library
WAITING_NOTICE_DELAY = 5.0  # [s]


def say(text: str, *, err: bool = False, nl: bool = True) -> None:
    """Print text without control characters; without a line end it is data, unchanged in a file or pipe."""
    stream = sys.stderr if err else sys.stdout
    click.echo(visible_text(text) if nl or stream.isatty() else text, err=err, nl=nl)


@contextmanager
def waiting(subject: object, timeout: float | None) -> Iterator[threading.Event]:
    """Print, after `WAITING_NOTICE_DELAY`, that the work on a file or a scene is still running; set an event then.

    Args:
        timeout: after which it is ended [s]; None for work in this process, which has no timeout.
    """
    ends = "" if timeout is None else f"stops itself after {timeout:g} s; "
    words = one_line(f"{subject}: running ({ends}Ctrl-C stops now)")
    printed = threading.Event()

    def notice() -> None:
        printed.set()
        say(words, err=True)

    timer = threading.Timer(WAITING_NOTICE_DELAY, notice)
    timer.daemon = True
    timer.start()
    try:
        yield printed
    finally:
        timer.cancel()
