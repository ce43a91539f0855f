"""Commands of before, as docs/before-0.1.0.md lists them, are answered with the new ones that stand beside them."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from command_line import conrod

from conrod.cli import VERBS

HISTORY = (Path(__file__).parents[2] / "docs/before-0.1.0.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^\| `conrod ([^`]+)` \| `conrod ([^`]+)` \|$", HISTORY, re.MULTILINE)


@pytest.mark.parametrize(("before", "now"), COMMANDS)
def test_listed_old_command_is_answered_with_the_new_one(before: str, now: str) -> None:
    done = conrod(*shlex.split(before))
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"conrod: `conrod {before}` is now `conrod {now}`\n"
    assert now.split(maxsplit=1)[0] in VERBS


def test_all_moved_commands_are_listed() -> None:
    verbs = {(before.split(maxsplit=1)[0], now.split(maxsplit=1)[0]) for before, now in COMMANDS}
    assert verbs == {("validate", verb) for verb in ("check", "forces", "free", "invariances", "validate")}
