"""`make mutants` fails where too many planted defects survive."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest
from killed_mutants import PAGE, function_of, listed, main, modules

ROOT = Path(__file__).parents[1]


NO_PAGE = "| `conrod.one.f` | no row of changes |"


def judged(folder: Path, page: str = NO_PAGE, lines: str = "", **codes: list[int | None]) -> int:
    """The exit status for modules whose mutants ended with these exit codes."""
    for name, ended in codes.items():
        codes_by_key = {f"conrod.{name}.x_f__mutmut_{k}": code for k, code in enumerate(ended)}
        text = json.dumps({"exit_code_by_key": codes_by_key})
        (folder / "conrod").mkdir(exist_ok=True)
        (folder / "conrod" / f"{name}.py.meta").write_text(text, encoding="utf-8")
    (folder / "page.md").write_text(page, encoding="utf-8")
    return main(str(folder), folder / "page.md", lambda _: lines)


@pytest.mark.parametrize(
    ("codes", "status"),
    [
        ([1] * 19 + [0], 0),
        ([1] * 18 + [0], 1),
        ([1] * 10 + [36, 3, -11], 0),  # hung, and ended otherwise
        ([1] * 100 + [None], 1),  # not run
        ([1] * 10 + [33], 1),  # no test reaches it
    ],
)
def test_a_module_below_the_bar_or_not_run_whole_fails(codes: list[int | None], status: int, tmp_path: Path) -> None:
    assert judged(tmp_path, good=[1] * 100, one=codes) == status


def test_modules_are_judged_one_by_one_and_survivors_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert judged(tmp_path, good=[1] * 100, bad=[1, 0, None], none=[]) == 1
    printed = capsys.readouterr()
    assert "conrod/bad.py: 1 of 2 killed, 0 equivalent, 50.0 %, 1 not run" in printed.out
    assert "survived: conrod.bad.x_f__mutmut_1" in printed.out
    assert "x_f__mutmut_2" not in printed.out, "it was not run"
    assert "below 95 %: conrod/bad.py" in printed.err
    assert "not run, `make mutants` goes on with them: 1" in printed.err
    assert [one.name for one in modules(tmp_path)] == ["conrod/bad.py", "conrod/good.py"]


def test_nothing_mutated_is_no_pass(tmp_path: Path) -> None:
    assert judged(tmp_path) == 1


@pytest.mark.parametrize(
    ("page", "status"),
    [
        ("| `conrod.one.f` | `x <= y` | they are never equal |", 0),
        ("| `conrod.one.f` | `x <= z`, `x <= y` | they are never equal |", 1),  # one of them is gone
        ("| `conrod.one.f` | `x <= y` | |", 1),  # no reason
        ("| `conrod.one.g` | `x <= y` | they are never equal |", 1),
        (NO_PAGE, 1),
    ],
)
def test_a_listed_mutant_that_changes_nothing_does_not_count_as_long_as_it_is_there(
    page: str, status: int, tmp_path: Path
) -> None:
    assert judged(tmp_path, page, "    if x <= y:", one=[1, 1, 0]) == status


def test_methods_are_listed_by_their_class() -> None:
    assert function_of("conrod.a.b.x__f__mutmut_12") == "conrod.a.b._f"
    assert function_of("conrod.a.b.xǁ_Cǁ__init____mutmut_2") == "conrod.a.b._C.__init__"


def test_what_is_mutated_and_what_kills_is_there_and_documented() -> None:
    asked = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["mutmut"]
    page = PAGE.read_text(encoding="utf-8")
    for file in asked["only_mutate"]:
        assert (ROOT / file).is_file()
        assert f"`{file.removeprefix('src/conrod/')}`" in page
    places = [arg.removeprefix("--deselect=").split("::")[0] for arg in asked["pytest_add_cli_args_test_selection"]]
    assert all((ROOT / place).exists() for place in places)
    files = {"/".join(file.removeprefix("src/").removesuffix(".py").split("/")) for file in asked["only_mutate"]}
    assert all(any(name.startswith(file.replace("/", ".")) for file in files) for name, _ in listed(page))
