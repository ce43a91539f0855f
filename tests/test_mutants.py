"""`make mutants` fails where too many planted defects survive."""

from __future__ import annotations

import functools
import json
import subprocess
import tomllib
from abc import abstractmethod
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from killed_mutants import PAGE, function_of, listed_changes, main, modules
from nearest_tests import FURTHER_SECONDS, STOPPED, Search, distance, exit_code_of, nearest_first
from sampled_mutants import copy_project, sample, with_getters

ROOT = Path(__file__).parents[1]


NO_PAGE = "| `conrod.one.f` | no row of changes |"


def exit_status_for(folder: Path, page: str = NO_PAGE, lines: str = "", **codes: list[int | None]) -> int:
    """The exit status for modules whose mutants ended with these exit codes."""
    for name, ended in codes.items():
        codes_by_key = {f"conrod.{name}.x_f__mutmut_{k}": code for k, code in enumerate(ended)}
        text = json.dumps({"exit_code_by_key": codes_by_key})
        (folder / "conrod").mkdir(exist_ok=True)
        (folder / "conrod" / f"{name}.py.meta").write_text(text, encoding="utf-8")
    (folder / "page.md").write_text(page, encoding="utf-8")
    return main(str(folder), folder / "page.md", lambda _: lines or Path.cwd().name)


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
    assert exit_status_for(tmp_path, good=[1] * 100, one=codes) == status


def test_modules_are_judged_one_by_one_and_survivors_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_status_for(tmp_path, good=[1] * 100, bad=[1, 0, None], none=[], stopped=[1, 2]) == 1
    printed = capsys.readouterr()
    assert "conrod/bad.py: 1 of 2 killed, 0 equivalent, 50.0 %, 1 not run" in printed.out
    assert "survived: conrod.bad.x_f__mutmut_1" in printed.out
    assert "x_f__mutmut_2" not in printed.out, "it was not run"
    assert "conrod/stopped.py: 1 of 2 killed" in printed.out
    assert f"lived within {FURTHER_SECONDS:g} s of further tests: conrod.stopped.x_f__mutmut_1" in printed.out
    assert "below 95 %: conrod/bad.py, conrod/stopped.py" in printed.err
    assert "not run, `make mutants` goes on with them: 1" in printed.err
    assert [one.name for one in modules(tmp_path)] == ["conrod/bad.py", "conrod/good.py", "conrod/stopped.py"]


def test_run_without_mutants_fails(tmp_path: Path) -> None:
    assert exit_status_for(tmp_path) == 1


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
def test_equivalent_mutant_counts_unless_listed_with_a_reason(page: str, status: int, tmp_path: Path) -> None:
    assert exit_status_for(tmp_path, page, "    if x <= y:", one=[1, 1, 0]) == status


def test_survivors_are_looked_up_where_mutmut_wrote_them(tmp_path: Path) -> None:
    folder, page = tmp_path / "copy" / "mutants" / "src", "| `conrod.one.f` | `{}` | it changes nothing |"
    folder.mkdir(parents=True)
    assert exit_status_for(folder, page.format("copy"), one=[1, 0]) == 0
    assert exit_status_for(folder, page.format("src"), one=[1, 0]) == 1


def test_sample_counts_chosen_mutants_and_fails_if_not_run(tmp_path: Path) -> None:
    folder = tmp_path / "mutants" / "src"
    folder.mkdir(parents=True)
    codes: list[int | None] = [1] * 30 + [0, None]
    for chosen, status in ((range(30), 0), (range(31), 0), ((0, 30), 1), ((0, 31), 1)):
        names = [f"conrod.one.x_f__mutmut_{k}" for k in chosen]
        (tmp_path / "chosen.json").write_text(json.dumps({"one": {"of": 32, "names": names}}), encoding="utf-8")
        assert exit_status_for(folder, one=codes) == status, chosen


def test_a_whole_run_writes_its_counts_into_the_page(tmp_path: Path) -> None:
    page = f"{NO_PAGE}\n<!-- counts -->\nold\n<!-- end of counts -->\n"
    exit_status_for(tmp_path, page, one=[1] * 39 + [None])
    assert "old" in (tmp_path / "page.md").read_text(encoding="utf-8")
    exit_status_for(tmp_path, page, one=[1] * 39 + [0])
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert "| `one.py` | 40 of 40 | 39 | 0 | 97.5 % |" in text
    assert "old" not in text


@pytest.mark.parametrize(
    ("file", "text", "near"),
    [
        ("tests/mjcf/test_loading.py", "", 0),
        ("tests/mjcf/test_loading_of_files.py", "", 0),
        ("tests/mjcf/loading/test_files.py", "", 0),
        ("tests/mjcf/test_words.py", "from conrod.mjcf.loading import load_model\n", 1),
        ("tests/mjcf/test_words.py", "import os\nfrom conrod.mjcf import causes, loading\n", 1),
        ("tests/mjcf/test_words.py", 'patch("conrod.mjcf.loading.load_model")', 1),
        ("tests/mjcf/test_words.py", "from conrod.mjcf.loadings import x\nfrom conrod import loading\n", 2),
        ("tests/mjcf/test_unloading.py", "from conrod.mjcf import causes\n", 2),
    ],
)
def test_tests_are_near_that_are_named_after_or_import_a_module(file: str, text: str, near: int) -> None:
    assert distance(file, text, "conrod.mjcf.loading") == near


def test_near_tests_come_first_and_quick_files_before_slow_ones() -> None:
    distances = {"far.py": 2, "quick.py": 2, "imports.py": 1, "named.py": 0}
    known = {"far.py::a": 0.1, "far.py::b": 3.0, "quick.py::a": 0.2, "imports.py::a": 9.0, "named.py::slow": 2.0}
    tests = ["far.py::b", "quick.py::a", "imports.py::a", "named.py::slow", "far.py::a", "named.py::new"]
    assert nearest_first(tests, distances, known) == [
        "named.py::new", "named.py::slow", "imports.py::a", "quick.py::a", "far.py::a", "far.py::b",
    ]  # fmt: skip


def search_of(durations: dict[str, float], monkeypatch: pytest.MonkeyPatch) -> Search:
    monkeypatch.setattr("nearest_tests.text_of", lambda _: "")
    return Search("conrod.mjcf.loading.x_f__mutmut_1", list(durations), durations)


@pytest.mark.parametrize(
    ("file", "spent", "stopped"),
    [
        ("tests/mjcf/test_lint.py", 0.9 * FURTHER_SECONDS, False),
        ("tests/mjcf/test_lint.py", 1.1 * FURTHER_SECONDS, True),
        ("tests/mjcf/test_loading.py", 1.1 * FURTHER_SECONDS, False),  # of a near test
    ],
)
def test_further_tests_stop_when_their_time_of_cpu_is_up(
    file: str, spent: float, stopped: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    limits, clock = list[tuple[int, int]](), iter([(3.0, 1.0, 0.5, 0.5, 99.0), (3.0 + spent, 1.0, 0.5, 0.5, 99.0)])
    monkeypatch.setattr("resource.getrlimit", lambda _: (700, 1000))
    monkeypatch.setattr("resource.setrlimit", lambda _, limit: limits.append(limit))
    monkeypatch.setattr("time.process_time", lambda: 40.0)
    monkeypatch.setattr("os.times", lambda: next(clock))
    search, session = search_of({f"{file}::a": 2.0, f"{file}::b": 90.0}, monkeypatch), SimpleNamespace(shouldstop=False)
    for name in "ab":
        item: Any = SimpleNamespace(nodeid=f"{file}::{name}", session=session)
        search.pytest_runtest_protocol(item)
    assert bool(session.shouldstop) is search.over is stopped
    # 60 s and fifteen times as long as usual beyond what was spent, within mutmut's own limit.
    assert limits == [(130, 1000), (1000, 1000)]


@pytest.mark.parametrize(
    ("codes", "over", "found", "files"),
    [
        ([0, 0, 0, 0], False, 0, [4, 8, 16, 12]),
        ([0, 5, 1], False, 1, [4, 8, 16]),  # none of eight files' tests is selected; one of sixteen fails
        ([2], False, 1, [4]),  # a file cannot be collected
        ([0, 2], True, STOPPED, [4, 8]),
        ([0, 1], True, 1, [4, 8]),  # the last one in time fails
        ([3], False, 3, [4]),
    ],
)
def test_files_are_collected_as_long_as_a_defect_lives(
    codes: list[int], over: bool, found: int, files: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    search = search_of({f"tests/test_{k:02d}.py::a": 0.1 * k for k in range(40)}, monkeypatch)
    search.over, collected = over, list[list[str]]()
    ends = iter(codes)
    assert exit_code_of(search, lambda some: (collected.append(some), next(ends))[1]) == found
    assert [len(some) for some in collected] == files
    assert collected[0] == [f"tests/test_0{k}.py" for k in range(4)]


def test_only_tests_that_reach_a_defect_are_run(monkeypatch: pytest.MonkeyPatch) -> None:
    durations = {"tests/test_words.py::b": 0.2, "tests/test_loading.py::a": 3.0, "tests/test_words.py::c": 0.1}
    search = search_of(durations, monkeypatch)
    items: Any = [SimpleNamespace(nodeid=name) for name in ("tests/test_words.py::other", *durations)]
    search.pytest_collection_modifyitems(items)
    assert [item.nodeid for item in items] == [
        "tests/test_loading.py::a",
        "tests/test_words.py::c",
        "tests/test_words.py::b",
    ]


SOURCE = '''
class Result:
    """A result."""

    @property
    def passed(self) -> bool:
        """Whether it passed."""
        return self.size < 1.0 and self.shape() > 2.0

    @functools.cached_property
    def size(self) -> float:
        return 0.5

    def shape(self) -> float:
        return 3.0

    @property
    @abstractmethod
    def none(self) -> int: ...
'''


def test_verdicts_that_are_properties_are_mutated_as_methods() -> None:
    written = with_getters(SOURCE)
    assert "    def _get_passed(self) -> bool:" in written
    assert "    passed = property(_get_passed)" in written
    space: dict[str, Any] = {"functools": functools, "abstractmethod": abstractmethod}
    exec(written, space)
    result = space["Result"]()
    assert result.passed is True
    assert (result.size, result.__dict__) == (0.5, {"size": 0.5})
    assert "def none(self)" in written


def test_edit_of_tests_or_code_plants_survivors_again(tmp_path: Path) -> None:
    root, copy = tmp_path / "root", tmp_path / "copy"
    source, claim, settings = (root / name for name in ("src/conrod/a.py", "tests/test_a.py", "pyproject.toml"))
    for file, text in (
        (source, "x = 1\n"),
        (claim, ""),
        (settings, '[tool.mutmut]\nonly_mutate = ["src/conrod/a.py"]\n'),
    ):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    subprocess.run(["git", "init", "-q", root], check=True)
    assert not copy_project(root, copy)
    results = copy / "mutants" / "src" / "conrod" / "a.py.meta"
    results.parent.mkdir(parents=True)
    results.write_text(json.dumps({"exit_code_by_key": {"killed": 1, "lived": 0, "unreached": 33}}), encoding="utf-8")
    assert copy_project(root, copy)
    assert json.loads(results.read_text())["exit_code_by_key"]["lived"] == 0, "nothing was edited"
    claim.write_text("assert True\n", encoding="utf-8")
    assert copy_project(root, copy)
    assert json.loads(results.read_text())["exit_code_by_key"] == {"killed": 1, "lived": None, "unreached": None}
    assert (copy / "tests" / "test_a.py").read_text() == "assert True\n"
    # Of code too: mutmut itself leaves out the results of functions that are not the same.
    source.write_text("x = 2\n", encoding="utf-8")
    assert copy_project(root, copy)
    assert (copy / "src" / "conrod" / "a.py").read_text() == "x = 2\n"
    assert json.loads(results.read_text())["exit_code_by_key"] == {"killed": 1, "lived": None, "unreached": None}


def test_sample_is_repeatable_and_starts_with_changed_functions() -> None:
    names = [f"conrod.m.x_{function}__mutmut_{k}" for function in "fg" for k in range(20)]
    drawn = sample(names, {"x_g"}, 25, "conrod/m.py")
    assert len(drawn) == 25
    assert all("x_g" in name for name in drawn[:20])
    assert drawn == sample(names, {"x_g"}, 25, "conrod/m.py")
    assert sample(names, set(), 5, "a") != sample(names, set(), 5, "b")
    assert len(sample(names, set(), 0, "a")) == 40


def test_methods_are_listed_by_their_class() -> None:
    assert function_of("conrod.a.b.x__f__mutmut_12") == "conrod.a.b._f"
    assert function_of("conrod.a.b.xǁ_Cǁ__init____mutmut_2") == "conrod.a.b._C.__init__"


def test_mutated_modules_and_their_tests_exist_and_are_listed() -> None:
    asked = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["mutmut"]
    page = PAGE.read_text(encoding="utf-8")
    for pattern in asked["only_mutate"]:
        assert list(ROOT.glob(pattern)), pattern
        assert f"`{pattern.removeprefix('src/conrod/')}`" in page
    places = [arg.removeprefix("--deselect=").split("::")[0] for arg in asked["pytest_add_cli_args_test_selection"]]
    assert all((ROOT / place).exists() for place in places)
    found = (file for pattern in asked["only_mutate"] for file in ROOT.glob(pattern))
    files = {str(file.relative_to(ROOT / "src").with_suffix("")) for file in found}
    assert all(any(name.startswith(file.replace("/", ".")) for file in files) for name, _ in listed_changes(page))
