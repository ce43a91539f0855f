"""An engine that another package brings takes part in studies with conrod's core alone."""

from __future__ import annotations

import json
import runpy
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from subprocess import CompletedProcess
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from command_line import conrod
from planted_engine import ENGINE, NAME, PlantedSettings, install_in

from conrod import PymunkSettings
from conrod.engines import (
    ENGINES,
    OPTIONAL_ENGINES,
    engine_named,
    engine_packages,
    installed_extras,
    line_style,
    load_plugin_here,
    loadable_engines,
    plugin_entry_points,
)
from conrod.engines.checked_plugin import describe
from conrod.errors import InvalidInput
from conrod.execution.resolve_arguments import select_engines
from conrod.execution.run import RunCase
from conrod.execution.worker import perform
from conrod.scenes import SCENES

DOCS = Path(__file__).parents[2] / "docs"
SAW: Any = SCENES["saw-40rpm"]
STEPS = 100


def forget() -> None:
    plugin_entry_points.cache_clear()
    engine_named.cache_clear()
    load_plugin_here.cache_clear()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the engine is installed, and where commands are given."""
    return install_in(tmp_path_factory.mktemp("site"))


@pytest.fixture(autouse=True)
def fresh() -> Iterator[None]:
    """Each test looks for engines anew, and leaves none behind."""
    forget()
    yield
    forget()


@pytest.fixture
def brought(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The planted engine, installed beside conrod."""
    monkeypatch.syspath_prepend(str(folder))


@pytest.fixture
def user(folder: Path, brought: None) -> Callable[..., CompletedProcess[str]]:
    """Gives commands as somebody who has installed the engine."""
    return partial(conrod, cwd=folder, ledger=folder / "ledger.sqlite")


def planted_error(settings: PlantedSettings) -> float:
    """Largest position error of an observed point of the saw over L, in a turn."""
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    exact, ahead = SAW.motion(angle, SAW.speed), SAW.motion(angle + settings.lead, SAW.speed)
    return max(
        float(np.linalg.norm(ahead.point(p).position - exact.point(p).position, axis=1).max() / length)
        for p, length in SAW.lengths.items()
    )


def validate_saw(user: Any, folder: Path, *arguments: str) -> tuple[int, dict[str | None, dict[str, Any]]]:
    """Exit status and results by preset."""
    asked = ("--engine", NAME, "--steps-per-rev", str(STEPS), *arguments)
    done = user("validate", "saw-40rpm", *asked, "--json", "r.json")
    assert done.returncode in (0, 1), done.stderr
    found = json.loads((folder / "r.json").read_text())["parts"]["saw-40rpm"]["findings"]
    return done.returncode, {result["preset"]: result for result in found["results"]}


def test_planted_error_and_order_are_measured(user: Any, folder: Path) -> None:
    status, results = validate_saw(user, folder, "--tolerance", "position=1e-2")
    for preset in ("stock", "sharp"):
        found = results[preset]
        settings = ENGINE.presets[preset](SAW, STEPS)
        assert found["outcome"] == "completed"
        assert found["order"] == pytest.approx(dict.fromkeys(found["order"], settings.order), abs=0.03)
        measured = max(found["errors"][point]["position"]["max"] for point in SAW.lengths)
        assert measured == pytest.approx(planted_error(settings), rel=1e-3)
    # The first order's 0.03 rad are over the tolerance, the third order's are not.
    assert (results["stock"]["passed"], results["sharp"]["passed"]) == (False, True)
    assert status == 1


def test_missing_capabilities_are_unsupported_with_a_reason(user: Any, folder: Path) -> None:
    _, results = validate_saw(user, folder)
    assert (results[None]["outcome"], results[None]["reason"]) == ("unsupported", "planted has no kinematic mode")
    assert results["sharp"]["passed"] is None  # it states no law of its errors to be judged by
    for verb, *options in (("forces", "--quantity", "torque"), ("free", "--seconds", "1")):
        done = user(verb, "saw-40rpm", "--engine", NAME, *options)
        assert done.returncode == 0, done.stderr
        assert "unsupported" in done.stdout
        assert f"{NAME} has no" in done.stdout.replace("\n", " ")
    ablated = user("ablate", "saw-40rpm", "--engine", NAME)
    assert ablated.returncode == 0, ablated.stderr
    assert f"{NAME} unsupported: {NAME} has no ingredients" in ablated.stdout


def test_a_plugin_is_swept_and_reported(user: Any, folder: Path) -> None:
    done = user("sweep", "saw-40rpm", "--engine", NAME, "--grid", "coarse", "--out", "swept", "--json", "swept.json")
    assert done.returncode == 0, done.stderr
    text = (folder / "swept.json").read_text()
    assert NAME in text
    assert "pymunk" not in json.loads(text)["environment"].get("engines", {})
    pages = "".join(path.read_text(encoding="utf-8") for path in (folder / "swept").rglob("*.md"))
    assert NAME in pages
    listed = user("results")
    assert listed.returncode == 0, listed.stderr
    assert NAME in listed.stdout


def test_a_plugin_is_listed_with_its_origin_and_capabilities(user: Any) -> None:
    done = user("engines")
    assert (done.returncode, done.stderr) == (0, "")
    assert ENGINE.version in done.stdout
    assert "planted-engine 1.0" in done.stdout
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("kinematic mode")]
    assert line.split()[2:5] == ["yes", "yes", "unsupported"]


# -- what is wrong costs one line, and nothing else -------------------------------------------------------------------

RAISES = """
from planted_engine import NAME, PlantedEngine

class Raises(PlantedEngine):
    def run(self, *_, **__):
        raise RuntimeError("the solver is lost")

ENGINE = Raises()
"""


def test_an_exception_of_a_plugin_ends_only_its_own_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "raises.py").write_text(RAISES)
    monkeypatch.syspath_prepend(str(install_in(tmp_path, "raises:ENGINE")))
    done = conrod("validate", "saw-40rpm", "--engine", NAME, cwd=tmp_path, ledger=tmp_path / "ledger.sqlite")
    assert (done.returncode, "Traceback" in done.stderr) == (1, False), done.stderr
    assert "crashed: RuntimeError: the solver is lost" in done.stdout


def test_an_exception_of_a_shipped_engine_is_an_internal_error(monkeypatch: pytest.MonkeyPatch) -> None:
    case = RunCase("saw-40rpm", SAW, PymunkSettings.stock(SAW, STEPS), 1.0)
    monkeypatch.setattr(type(engine_named("pymunk")), "run", staticmethod(lambda *_: 1 / 0))
    with pytest.raises(ZeroDivisionError):
        perform(case)


@pytest.mark.usefixtures("brought")
def test_engine_all_selects_every_installed_engine() -> None:
    found = [one.name for one in select_engines(["all"])]
    assert found == [*ENGINES, NAME, *installed_extras()]
    assert [one.name for one in select_engines([NAME, "pymunk", NAME])] == [NAME, "pymunk"]
    assert [one.name for one in select_engines([])] == [*ENGINES, NAME]
    assert engine_named(NAME).description == describe(ENGINE, NAME)  # type: ignore[attr-defined]
    assert engine_packages()[-1] == "planted-engine"
    assert line_style(NAME, "sharp") == ENGINE.presets["sharp"].style


def test_documented_capabilities_are_those_of_the_engines() -> None:
    made: Any = SimpleNamespace(**runpy.run_path(str(DOCS / "capabilities.py")))
    shown = made.PAGE.read_text(encoding="utf-8").split(made.BEGIN)[1].split(made.END)[0]
    # Only what is installed can be asked: column by column.
    installed = [one for one in loadable_engines(installed_extras())[0] if one.name in {**ENGINES, **OPTIONAL_ENGINES}]
    assert columns(made.text_of(installed)).items() <= columns(shown).items(), "python docs/capabilities.py"
    # Negative control: capabilities more are noticed, whichever engines are installed.
    assert not columns(made.text_of(installed)).items() <= columns(shown.replace("unsupported", "yes")).items()


def columns(text: str) -> dict[str, tuple[str, ...]]:
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines()]
    return {head: tuple(cells) for head, *cells in zip(*rows, strict=True)}


# -- the registry ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "name", "reason"),
    [
        ("no_such_module:ENGINE", "broken", "cannot be loaded"),
        ("planted_engine:ENGINE", "other", "no object of a class that extends Engine, of this name"),
        ("planted_engine:PlantedEngine", NAME, "no object of a class that extends Engine"),
    ],
)
def test_an_engine_that_cannot_be_loaded_is_named(
    value: str, name: str, reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(install_in(tmp_path, value, name)))
    with pytest.raises(InvalidInput, match=f"engine '{name}'.*{reason}"):
        engine_named(name)


def test_a_broken_plugin_is_refused_only_when_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(install_in(tmp_path, "no_such_module:ENGINE", "broken")))
    words = ("validate", "saw-40rpm", "--steps-per-rev", "100", "--revolutions", "1")
    named = conrod(*words, "--engine", "broken", cwd=tmp_path, ledger=tmp_path / "ledger.sqlite")
    assert (named.returncode, named.stdout, named.stderr.count("\n")) == (2, "", 1)
    unnamed = conrod(*words, cwd=tmp_path, ledger=tmp_path / "ledger.sqlite")
    assert unnamed.returncode in (0, 1)
    assert "conrod: left out: engine 'broken'" in unnamed.stderr
    assert "pymunk" in unnamed.stdout
