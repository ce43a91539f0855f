"""Help of one screen, options that mean the same in every verb, and what a shell completes."""

from __future__ import annotations

from collections.abc import Iterator

import click
import pytest
from command_line import conrod

from conrod.cli import VERBS, cli
from conrod.cli.options import HEADING, SHARED

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


@pytest.mark.parametrize("name", VERBS)
def test_all_help_has_every_option_once_under_its_heading(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, short = (help_of(name, asked, monkeypatch=monkeypatch) for asked in ("--help-all", "--help"))
    for option in options_of(verb(name)):
        heading = getattr(option, "heading", HEADING)
        assert heading + ":" in whole
        listed = [
            line for line in whole.partition(HEADING + ":")[2].splitlines() if line.split()[:1] == option.opts[:1]
        ]
        listed += [line for line in whole.splitlines() if line.strip().startswith(f"{option.opts[0]}, ")]
        assert len(listed) == 1, option.opts
        assert option.opts[-1] in short


@pytest.mark.parametrize("option", SHARED)
def test_an_option_means_the_same_in_every_verb(option: str) -> None:
    found = [one for name in VERBS for one in options_of(verb(name)) if option in one.opts]
    assert found
    said = {(one.metavar, one.help, one.multiple, one.default, str(one.type)) for one in found}
    assert len(said) == 1, said
