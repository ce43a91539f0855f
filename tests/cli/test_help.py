"""Help of one screen, options that mean the same in every verb, and what a shell completes."""

from __future__ import annotations

from collections.abc import Iterator

import click
import pytest
from command_line import conrod

from conrod.cli import VERBS, cli
from conrod.cli.options import SHARED

LINES, COLUMNS = 24, 80
CONTEXT = click.Context(cli)


def verb(name: str) -> click.Command:
    found = cli.get_command(CONTEXT, name)
    assert found is not None
    return found


def options_of(command: click.Command) -> Iterator[click.Option]:
    return (one for one in command.params if isinstance(one, click.Option))


def help_of(*arguments: str, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("COLUMNS", str(COLUMNS))
    done = conrod(*arguments)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def fits_one_screen(text: str) -> bool:
    lines = text.splitlines()
    return len(lines) <= LINES and max(map(len, lines)) <= COLUMNS


@pytest.mark.parametrize("arguments", [(), *((name,) for name in VERBS)])
def test_help_is_one_screen(arguments: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    assert fits_one_screen(help_of(*arguments, "--help", monkeypatch=monkeypatch))


@pytest.mark.parametrize("option", SHARED)
def test_an_option_means_the_same_in_every_verb(option: str) -> None:
    found = [one for name in VERBS for one in options_of(verb(name)) if option in one.opts]
    assert found
    said = {(one.metavar, one.help, one.multiple, one.default, str(one.type)) for one in found}
    assert len(said) == 1, said
