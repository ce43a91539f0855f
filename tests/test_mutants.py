"""`make mutants` fails where too many planted defects survive."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest
from killed_mutants import main, modules

ROOT = Path(__file__).parents[1]


def left_by_mutmut(folder: Path, **codes: list[int | None]) -> str:
    """What mutmut leaves of modules whose mutants ended with these exit codes."""
    for name, ended in codes.items():
        text = json.dumps({"exit_code_by_key": {f"{name}_{k}": code for k, code in enumerate(ended)}})
        (folder / "conrod").mkdir(exist_ok=True)
        (folder / "conrod" / f"{name}.py.meta").write_text(text, encoding="utf-8")
    return str(folder)


@pytest.mark.parametrize(
    ("codes", "status"),
    [
        ([1] * 19 + [0], 0),
        ([1] * 18 + [0], 1),
        ([1] * 10 + [36, 3, -11], 0),  # hung, and ended otherwise
        ([1] * 10 + [None], 1),  # not run
        ([1] * 10 + [33], 1),  # no test reaches it
    ],
)
def test_a_module_below_the_bar_fails(codes: list[int | None], status: int, tmp_path: Path) -> None:
    assert main(left_by_mutmut(tmp_path, good=[1] * 100, one=codes)) == status


def test_modules_are_judged_one_by_one_and_survivors_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(left_by_mutmut(tmp_path, good=[1] * 100, bad=[1, 0], none=[])) == 1
    printed = capsys.readouterr()
    assert "conrod/bad.py: 1 of 2 killed, 50.0 %" in printed.out
    assert "survived: bad_1" in printed.out
    assert "below 95 %: conrod/bad.py" in printed.err
    assert [one.name for one in modules(tmp_path)] == ["conrod/bad.py", "conrod/good.py"]


def test_nothing_mutated_is_no_pass(tmp_path: Path) -> None:
    assert main(str(tmp_path)) == 1


def test_what_is_mutated_and_what_kills_is_there_and_documented() -> None:
    asked = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["mutmut"]
    page = (ROOT / "docs" / "mutants.md").read_text(encoding="utf-8")
    for file in asked["only_mutate"]:
        assert (ROOT / file).is_file()
        assert f"`{file.removeprefix('src/conrod/')}`" in page
    assert all((ROOT / place).exists() for place in asked["pytest_add_cli_args_test_selection"])
