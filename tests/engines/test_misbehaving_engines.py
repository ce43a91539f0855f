"""What an engine of another package does ends its own cells, with the reason, and nothing else."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import planted_engine
import pytest
from command_line import conrod, conrod_process
from misbehaving_engines import CASES, FAST, HARMLESS, install_in

from conrod.engines import engine_named, load_plugin_here, plugin_entry_points

COMMAND = ("validate", "saw-40rpm", "--steps-per-rev", "20", "--revolutions", "1")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return install_in(tmp_path_factory.mktemp("site"))


def study_results(folder: Path, names: Sequence[str]) -> dict[tuple[str, str | None], dict[str, Any]]:
    """Results by engine and preset of one study of MuJoCo and some of them."""
    named = [word for name in ("mujoco", *names) for word in ("--engine", name)]
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        forget()
        done = conrod(*COMMAND, *named, "--json", "r.json", cwd=folder, ledger=folder / "l.sqlite", own_workers=True)
    forget()
    assert done.returncode == 1, done.stderr
    assert "Traceback" not in done.stderr
    found = json.loads((folder / "r.json").read_text())["parts"]["saw-40rpm"]["findings"]["results"]
    return {(one["engine"], one["preset"]): one for one in found}


def forget() -> None:
    for known in (plugin_entry_points, engine_named, load_plugin_here):
        known.cache_clear()


@pytest.fixture(scope="module")
def answers(folder: Path) -> Callable[[str], dict[tuple[str, str | None], dict[str, Any]]]:
    """The results of the study that has an engine."""
    groups = {True: FAST, False: tuple(name for name in (*CASES, *HARMLESS) if name not in FAST)}
    known = cache(lambda fast: study_results(folder, groups[fast]))
    return lambda name: known(name in FAST)


def engine_params(names: Iterable[str]) -> list[Any]:
    return [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in names]


@pytest.mark.parametrize("name", engine_params(CASES))
def test_a_misbehaving_engine_ends_only_its_own_run(name: str, answers: Any) -> None:
    found = answers(name)[name, "sharp"]
    assert found["outcome"] in ("crashed", "diverged"), found
    assert CASES[name][1] in found["reason"]
    assert "\x1b" not in found["reason"]
    assert "\n" not in found["reason"]
    assert found["passed"] is not True


@pytest.mark.parametrize("name", engine_params(HARMLESS))
def test_a_plugin_cannot_change_the_comparison(name: str, answers: Any) -> None:
    found = answers(name)[name, "sharp"]
    assert found["outcome"] == "completed", found["reason"]
    planted = found["errors"]["C"]["position"]["max"]
    assert 1e-3 < planted < 1e-1  # half a radian over steps a radian, cubed


@pytest.mark.parametrize("name", engine_params(("nan", "aborts")))
def test_a_misbehaving_engine_changes_no_other_result(name: str, answers: Any, tmp_path: Path) -> None:
    alone = conrod(*COMMAND, "--engine", "mujoco", "--json", "r.json", cwd=tmp_path, ledger=tmp_path / "l.sqlite")
    assert alone.returncode == 0, alone.stderr
    for one in json.loads((tmp_path / "r.json").read_text())["parts"]["saw-40rpm"]["findings"]["results"]:
        beside = answers(name)[one["engine"], one["preset"]]
        # Samples are the marks of a figure that all runs share, so that each run has fewer where there are more.
        assert {**beside, "samples": None} == {**one, "samples": None}


# -- as it is loaded ---------------------------------------------------------------------------------------------------

PLANTED = "from planted_engine import PlantedEngine\nENGINE = PlantedEngine()\n"
LOADED = {
    "import os; os._exit(3)": "the process that asked it ended with status 3",
    "import sys; sys.exit('gone')": "SystemExit: gone",
    "import os; os.abort()": "ended by signal SIGABRT",
    "raise type('Own', (BaseException,), {})('lost')": "Own: lost",
    f"{PLANTED}ENGINE.presets = {{}}": "it handed over no preset",
    f"{PLANTED}ENGINE.version = 3": "a version that is of int",
}


@pytest.mark.parametrize("code", LOADED, ids=lambda code: code.splitlines()[-1])
def test_an_engine_that_fails_to_load_is_left_out(code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "wrong.py").write_text(code)
    monkeypatch.syspath_prepend(str(planted_engine.install_in(tmp_path, "wrong:ENGINE")))
    forget()
    done = conrod("engines", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert LOADED[code] in " ".join(done.stdout.split())
    assert "mujoco" in done.stdout


def test_loading_a_plugin_changes_nothing_in_conrods_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code = "import numpy as np, os\nnp.sum = None\nos.chdir('/')\nfrom planted_engine import ENGINE\nprint('loaded')\n"
    (tmp_path / "patching.py").write_text(code)
    folder = planted_engine.install_in(tmp_path, "patching:ENGINE")
    monkeypatch.setenv("PYTHONPATH", f"{folder}:{Path(__file__).parents[1] / 'support'}")
    done = conrod_process(*COMMAND, "--engine", "mujoco", "--engine", "planted", "--json", "r.json", cwd=tmp_path)
    assert done.returncode in (0, 1), done.stderr
    found = json.loads((tmp_path / "r.json").read_text())["parts"]["saw-40rpm"]["findings"]["results"]
    ended = {one["preset"]: (one["outcome"], one["reason"]) for one in found if one["preset"] is not None}
    assert ended["hardened"] == ("completed", "")
    assert ended["sharp"] == ("crashed", "it changed numpy.sum, which its errors are worked out with")


def test_two_plugins_of_one_name_are_both_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for distribution in ("planted-engine", "other-engine"):
        folder = planted_engine.install_in(tmp_path / distribution, distribution=distribution)
        monkeypatch.syspath_prepend(str(folder))
    forget()
    said = "engine 'planted' is brought by other-engine 1.0 and planted-engine 1.0: uninstall all but one of them"
    named = conrod(*COMMAND, "--engine", "planted", cwd=tmp_path, ledger=tmp_path / "l.sqlite")
    assert (named.returncode, named.stderr) == (2, f"conrod: {said}\n")
    listed = conrod("engines", cwd=tmp_path)
    assert (listed.returncode, said in " ".join(listed.stdout.split())) == (0, True)
