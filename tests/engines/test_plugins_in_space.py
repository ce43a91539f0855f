"""Engines of other packages on machines in space: what they hand over is checked, and costs their own rows alone."""

from __future__ import annotations

import json
import pickle
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import planted_space
import pytest
from command_line import conrod
from planted_space import CASES, LEAD

from conrod.engines import engine_named, load_plugin_here, plugin_entry_points
from conrod.engines.capabilities import SpatialRuns
from conrod.engines.checked_plugin import CheckedPlugin, numpy_functions
from conrod.engines.space import SpatialStart
from conrod.exact.space.drive_laws import parse_drive_law
from conrod.scenes.space import MACHINES
from conrod.scenes.space.tree import law_period, machine_laws
from conrod.studies.space import study
from conrod.studies.space.plan import SpatialCell, motion_scales
from conrod.studies.space.results import SpatialResult
from conrod.studies.space.study import prepare_bench, run_cell

COMMAND = ("validate", "bennett", "--steps-per-rev", "20", "--revolutions", "1", "--preset", "sharp")
# Engines of a command that ends in seconds: it starts two processes for each. The others are slow.
NAMED = ("space-good", "space-leaves")


@cache
def bennett_scales() -> Mapping[str, float]:
    return motion_scales(MACHINES["bennett"]())


def cell_result(name: str, monkeypatch: pytest.MonkeyPatch) -> SpatialResult:
    """Result of a planted engine on Bennett's linkage, loaded into this process."""
    checked = CheckedPlugin(CASES[name][0], name, numpy_functions())
    monkeypatch.setattr(study, "engine_named", lambda _: checked)
    monkeypatch.setattr(study, "motion_scales", lambda _: bennett_scales())
    monkeypatch.setattr(SpatialCell, "empty_result", empty_result)
    return run_cell(SpatialCell("bennett", name, "sharp", (20,), 1))


def empty_result(cell: SpatialCell) -> SpatialResult:
    return SpatialResult(
        scene=cell.machine, engine=cell.engine, engine_version="1.0", preset=cell.preset, steps_per_rev=20,
        revolutions=1,
    )  # fmt: skip


@pytest.fixture(autouse=True)
def restored_numpy() -> Iterator[None]:
    norm = np.linalg.norm
    yield
    np.linalg.norm = norm  # type: ignore[assignment]


@pytest.mark.parametrize("name", [name for name in CASES if name not in ("space-leaves", "space-aborts")])
def test_misbehaviour_in_space_has_outcome_and_reason(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found = cell_result(name, monkeypatch)
    _, outcome, reason = CASES[name]
    assert found.outcome == outcome, found.reason
    assert reason in found.reason
    assert "\n" not in found.reason


@pytest.mark.parametrize("name", ["space-good", "space-mutates"])
def test_planted_lead_is_measured_in_space(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found = cell_result(name, monkeypatch)
    scales, period = bennett_scales(), law_period(machine_laws(MACHINES["bennett"]()))
    led = LEAD / 20.0**3 * period * scales["velocity"] / scales["position"]  # at the largest speed
    assert found.largest("position") == pytest.approx(led, rel=0.02)
    assert found.largest("closure") < 1e-12  # type: ignore[operator]


def run_command(folder: Path, names: tuple[str, ...]) -> Mapping[str, Mapping[str, Any]]:
    """Results by engine of one command."""
    named = [word for name in names for word in ("--engine", name)]
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        forget_engines()
        done = conrod(*COMMAND, *named, "--json", "r.json", cwd=folder, own_workers=True)
    forget_engines()
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    found = json.loads((folder / "r.json").read_text())["parts"]["bennett"]["findings"]["results"]
    return {one["engine"]: one for one in found}


def forget_engines() -> None:
    for known in (plugin_entry_points, engine_named, load_plugin_here):
        known.cache_clear()


@pytest.mark.parametrize("names", [NAMED, pytest.param(tuple(CASES), marks=pytest.mark.slow)], ids=["some", "all"])
def test_misbehaving_engine_in_space_ends_its_own_row(names: tuple[str, ...], tmp_path: Path) -> None:
    found = run_command(planted_space.install_in(tmp_path), names)
    for name in names:
        _, outcome, reason = CASES[name]
        assert found[name]["outcome"] == outcome, found[name]
        assert reason in found[name]["reason"]


def test_engines_lists_the_runs_of_a_plugin_in_space(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planted_space, "CASES", {"space-good": CASES["space-good"]})
    monkeypatch.syspath_prepend(str(planted_space.install_in(tmp_path)))
    forget_engines()
    assert load_plugin_here("space-good").has_capability(SpatialRuns)
    forget_engines()


# -- what is sent --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MACHINES)
def test_spatial_start_is_the_same_when_sent(name: str) -> None:
    start = prepare_bench(name).start
    sent: SpatialStart = pickle.loads(pickle.dumps(start))
    times = np.linspace(0.0, 1.3 * start.period, 7)
    for joint, law in start.machine.laws.items():
        assert np.array_equal(sent.machine.laws[joint].derivatives(times), law.derivatives(times))
    assert np.array_equal(sent.exact.coordinates, start.exact.coordinates)
    assert sent.points.keys() == start.points.keys()


@pytest.mark.parametrize("text", ["hold", "60rpm", "sine:20deg,1Hz", "move:0deg,90deg,2s", "table:{}"])
def test_drive_law_is_the_same_when_sent(text: str, tmp_path: Path) -> None:
    rows = np.linspace(0.0, 0.5, 9)
    np.savetxt(tmp_path / "law.csv", np.column_stack([rows, np.sin(rows)]), delimiter=",")
    law = parse_drive_law(text.format(tmp_path / "law.csv"), "rad", 0.3, "crank")
    sent, times = pickle.loads(pickle.dumps(law)), np.linspace(0.0, 3.0, 50)
    assert np.array_equal(sent.derivatives(times), law.derivatives(times))
    assert (sent.text, sent.duration) == (law.text, law.duration)
