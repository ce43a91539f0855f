"""`conrod sweep`, `recommend`, `results`, `limits` and `ablate` as a user types them."""

from __future__ import annotations

import csv
import io
import json
import random
import re
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import command_line
import mujoco
import numpy as np
import pytest

from conrod import SCENES, PymunkSettings, compare, run
from conrod.comparison.plain_values import restore
from conrod.engines.mujoco.engine import MuJoCo
from conrod.engines.variants import Ingredient
from conrod.execution.ledger import Ledger
from conrod.report.folder import restore_findings
from conrod.studies.ablate.findings import AblationStudy
from conrod.studies.limits.results import LimitStudy

# Runs of a coarse grid that take a second or two.
QUICK = ("saw-500rpm", "--engine", "pymunk", "--grid", "coarse")
RECOMMEND = ("recommend", *QUICK[:3])


def conrod(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return command_line.conrod(*arguments, "--ledger", "l.sqlite", cwd=cwd, ledger=cwd / "default.sqlite")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder whose ledger has the coarse grid, and what a search has run."""
    made = tmp_path_factory.mktemp("recommend")
    done = conrod(*RECOMMEND, "--position", "1e-3", cwd=made)
    assert done.returncode == 0, done.stderr
    (made / "first.txt").write_text(done.stdout)
    assert conrod("sweep", *QUICK, cwd=made).returncode == 0
    return made


def test_confirmed_recommendation_as_pasted_keeps_its_error(folder: Path) -> None:
    text = (folder / "first.txt").read_text()
    for words in (
        "of 0.001 (0.21 mm) allowed",
        "confirmed: as pasted",
        "start at 37 deg",
        "five revolutions",
        "speed +10%",
    ):
        assert words in text, words
    # The pasted statements are run on what stands for a `pymunk.Space`, and what they set is run on the machine.
    steps: list[float] = []
    space: Any = SimpleNamespace(constraints=[SimpleNamespace()], step=steps.append)
    exec(textwrap.dedent(text.split("to paste:\n")[1]), {"space": space})
    saw = SCENES["saw-500rpm"]
    (step,) = steps
    set_to = {"iterations": space.iterations, "error_bias": space.constraints[0].error_bias}
    settings = PymunkSettings("custom", round(saw.period / step), step, **set_to)
    assert compare(run(saw, settings), saw).worst("position") <= 1e-3


def test_model_with_pasted_lines_keeps_error_in_plain_mujoco(tmp_path: Path) -> None:
    files = ("--model", "saw.xml", "--json", "saw.json")
    done = conrod("recommend", "saw-500rpm", "--engine", "mujoco", "--position", "1e-6", *files, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads((tmp_path / "saw.json").read_text())["parts"]["saw-500rpm"]["findings"]
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "saw.xml"))
    elements, _, statements = found["answers"]["mujoco"]["paste"].partition("# after compiling")
    # All lines for a model stand in the file, with short numbers.
    written = "".join((tmp_path / "saw.xml").read_text().split())
    for element in re.findall(r"<(?:option|connect) [^>]*?/?>", elements):
        assert "".join(element.split()) in written
    assert max(len(n) for n in re.findall(r"[\d.]+", elements)) <= 10
    assert error_in_plain_mujoco(model) > 1e-6  # the negative control: what no file can say is needed
    exec(statements.partition("\n")[2], {"model": model})
    assert error_in_plain_mujoco(model) <= 1e-6


def test_model_file_of_pymunk_has_the_recommended_settings(tmp_path: Path) -> None:
    files = ("--model", "saw.py", "--json", "saw.json")
    done = conrod("recommend", "saw-500rpm", "--engine", "pymunk", "--position", "1e-3", *files, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads((tmp_path / "saw.json").read_text())["parts"]["saw-500rpm"]["findings"]
    text = (tmp_path / "saw.py").read_text()
    iterations, step = re.search(r"iterations = (.*)[^$]*step\((.*)\)", found["answers"]["pymunk"]["paste"]).groups()
    assert f"ITERATIONS = {iterations} " in text
    assert f"TIMESTEP = {step} " in text


def error_in_plain_mujoco(model: Any) -> float:
    """Largest position error over two turns from the keyframe, over the travel, by nothing but MuJoCo's own API."""
    saw, data, angles, places = SCENES["saw-500rpm"], mujoco.MjData(model), [], []
    mujoco.mj_resetDataKeyframe(model, data, model.key("start").id)
    for _ in range(round(2.0 * saw.period / model.opt.timestep)):
        angles.append(float(data.qpos[model.joint("crank").qposadr[0]]))
        mujoco.mj_step(model, data)  # sensors belong to the instant before it
        places.append(data.sensor("C.position").data[:2].copy())
    exact = saw.motion(np.array(angles), saw.speed).point("C").position
    return float(np.linalg.norm(np.array(places) - exact, axis=1).max() / saw.lengths["C"])


def test_recommend_names_nearest_with_status_1_if_none_qualifies(folder: Path) -> None:
    done = conrod(*RECOMMEND, "--position", "1e-12", cwd=folder)
    assert done.returncode == 1
    assert "nothing qualifies: position is" in done.stdout
    assert "nearest: " in done.stdout


def test_results_are_a_tidy_table(folder: Path) -> None:
    rows = list(csv.DictReader(io.StringIO(conrod("results", cwd=folder).stdout)))
    assert {row["scene"] for row in rows} == {"saw-500rpm"}
    assert {row["outcome"] for row in rows} >= {"completed", "opened"}
    failed = [row for row in rows if row["outcome"] == "opened"]
    assert all(row["position_max"] == "" and row["reason"] for row in failed)
    assert len({row["key"] for row in rows}) == len(rows)
    assert conrod("results", "--json", "a.json", cwd=folder).returncode == 0
    objects = json.loads((folder / "a.json").read_text())
    assert [row["position_max"] for row in rows] == [str(row["position_max"] or "") for row in objects]


def begun_sweep(folder: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-m", "conrod", "sweep", "saw-500rpm", "--engine", "pymunk", "--ledger", "l.sqlite"],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        # A shell starts what runs in its background with the signal ignored, and that is inherited.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509  nothing runs beside it
    )  # fmt: skip


@pytest.mark.parametrize("sent", [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_interrupted_sweep_keeps_runs_and_says_how_to_go_on(sent: signal.Signals, tmp_path: Path) -> None:
    process = begun_sweep(tmp_path)
    with Ledger.open(tmp_path / "l.sqlite") as ledger:
        while not any(ledger.rows()):
            time.sleep(0.1)
    process.send_signal(sent)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "the same command goes on from there" in errors
    assert "Traceback" not in errors
    assert conrod("results", cwd=tmp_path).stdout.count("\n") > 1


@pytest.mark.slow
@pytest.mark.parametrize("start", range(30))
def test_sweep_ends_as_interrupted_whenever_it_is_told_to(start: int, tmp_path: Path) -> None:
    process = begun_sweep(tmp_path)
    time.sleep(random.Random(start).uniform(0.0, 4.0))
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=120)
    # While it is still being loaded it ends as any program; before and after, by whom it is told, never by a fault.
    assert process.returncode in (0, 130, -signal.SIGTERM), errors
    assert "internal error" not in errors


# -- limits ------------------------------------------------------------------------------------------------------------

# Two dozen runs of a second or two in all.
LIMITS = ("saw-500rpm", "--axis", "steps", "--engine", "pymunk", "--preset", "stock", "--range", "400..2")


def run_limits(folder: Path) -> tuple[str, LimitStudy, int]:
    """What a quick study prints, what it finds, and the number of runs that are kept."""
    done = conrod("limits", *LIMITS, "--json", "limits.json", cwd=folder)
    assert done.returncode == 0, done.stderr
    (part,) = json.loads((folder / "limits.json").read_text())["parts"].values()
    with Ledger.open(folder / "l.sqlite") as ledger:
        return done.stdout, restore(LimitStudy, part["findings"]), len(list(ledger.rows()))


def test_limits_finds_boundaries_and_the_same_again_with_no_run(tmp_path: Path) -> None:
    printed, study, runs = run_limits(tmp_path)
    (walk,) = study.walks
    boundary = {b.criterion: b for b in walk.boundaries}["wrong"]
    # Saw at 500 rpm, stock pymunk: a joint gapes by a twentieth of the travel between 30 and 100 steps.
    assert 20 < boundary.first_bad < boundary.last_good < 100
    assert boundary.last_good <= 1.02 * boundary.first_bad + 1.0
    assert (boundary.outcome, boundary.undetected) == ("opened", True)
    for words in ("opened (undetected)", "within 1 %", "within 10 %"):
        assert words in printed
    assert run_limits(tmp_path)[1:] == (study, runs)


# -- ablate ------------------------------------------------------------------------------------------------------------


def add_iterations(more: int) -> Callable[[Any], Any]:
    return lambda settings: replace(settings, preset="custom", iterations=settings.iterations + more)


ABLATE = ("ablate", "saw-500rpm", "--engine", "mujoco", "--steps-per-rev", "100", "--rounds", "2", "--jobs", "1")


def test_ablation_is_printed_written_and_not_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    planted = Ingredient("more-iterations", "fifty more", add_iterations(50), add_iterations(-50))
    monkeypatch.setattr(MuJoCo, "ingredients", lambda self, machine, minimal: (planted,))
    first = conrod(*ABLATE, "--out", "report", "--json", "a.json", cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    assert "1 ingredient can go: that makes a step" in first.stdout
    study = findings(tmp_path / "a.json")
    # The one ingredient is all of the dressed model: with it and without it are the two models that there are.
    assert [(v.role.value, v.outcome) for v in study.engines[0].variants] == [
        (role, "completed") for role in ("minimal", "added", "full", "taken")
    ]
    page = (tmp_path / "report" / "saw-500rpm.md").read_text()
    assert "`conrod ablate saw-500rpm --engine mujoco --steps-per-rev 100 --rounds 2 --out report`" in page
    again = conrod(*ABLATE, "--json", "b.json", cwd=tmp_path)
    assert re.findall(r"(\d+) done", again.stderr) == ["0", "0"]
    assert findings(tmp_path / "b.json") == study


def findings(file: Path) -> AblationStudy:
    return restore_findings(AblationStudy, json.loads(file.read_text())["parts"]["saw-500rpm"]["findings"])
