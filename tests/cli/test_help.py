"""Help that a screen or three hold, and options that mean the same in every verb."""

from __future__ import annotations

from collections.abc import Iterator

import click
import pytest
from command_line import conrod

from conrod.cli import VERBS, cli
from conrod.cli.options import SHARED

SCREEN = 24  # lines
CONTEXT = click.Context(cli)


def options_of(name: str) -> Iterator[click.Option]:
    command = cli.get_command(CONTEXT, name)
    assert command is not None
    return (one for one in command.params if isinstance(one, click.Option))


@pytest.mark.parametrize("verb", VERBS)
def test_help_has_every_option_on_few_screens(verb: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "100")
    lines = conrod(verb, "--help").stdout.splitlines()
    assert len(lines) <= (3 if verb == "validate" else 1.5) * SCREEN
    assert max(map(len, lines)) <= 100
    for option in options_of(verb):
        assert any(line.split()[:1] in ([name], [f"{name},"]) for line in lines for name in option.opts), option


@pytest.mark.parametrize("option", SHARED)
def test_an_option_means_the_same_in_every_verb(option: str) -> None:
    found = [one for name in VERBS for one in options_of(name) if option in one.opts]
    assert found
    said = {(one.metavar, one.help, one.multiple, one.default, str(one.type)) for one in found}
    assert len(said) == 1, said
