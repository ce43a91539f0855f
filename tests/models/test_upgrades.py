"""What an upgrade changes in a model: planted releases, each with one slip, are named by it and by its time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from conrod.cli import cli
from conrod.engines.releases import ChangelogEntry, Releases
from conrod.errors import InvalidInput
from conrod.execution.paired_timing import PairedTiming
from conrod.models.upgrades import release_calls
from conrod.models.upgrades.report import UPGRADES_REPORT, changes_table, costs_table, headline
from conrod.models.upgrades.results import COMPILED, REFUSED, ROUNDING, TERM, ModelCost, ModelRun, UpgradeStudy
from conrod.models.upgrades.study import upgrade_study
from conrod.report.findings import Findings

OLD, NEW = "3.17.0", "4.0.0"
FACTS = (ChangelogEntry(NEW, "Shapes collide otherwise.", contact=True), ChangelogEntry(NEW, "Bits.", rounding=True))
RELEASES = Releases("its changelog", {"3.2.0": "mujoco"}, (OLD, NEW), FACTS)

BALL = """
<mujoco>
  <option timestep="0.002"/>
  <worldbody>
    <geom name="floor" type="plane" size="1 1 0.1"/>
    <body name="ball" pos="0 0 0.3">
      <joint name="drop" type="slide" axis="0 0 1"/>
      <geom name="skin" size="0.1"/>
    </body>
  </worldbody>
</mujoco>
"""
# A double pendulum that falls over, undamped: after some 15 s it is elsewhere by a bit at its start.
PENDULUM = """
<mujoco>
  <option timestep="0.01" integrator="RK4"/>
  <worldbody>
    <body name="upper" pos="0 0 2">
      <joint name="shoulder" axis="0 1 0"/>
      <geom type="capsule" size="0.02" fromto="0 0 0 0.5 0 0.1" contype="0"/>
      <body name="lower" pos="0.5 0 0.1">
        <joint name="elbow" axis="0 1 0"/>
        <geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.5" contype="0"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def study_of(
    folder: Path, text: str, plant: Callable[[Any, tuple[Any, ...]], Any], seconds: float = 0.6
) -> UpgradeStudy:
    """The study of a model in two planted releases: the newer one calls `plant` in place of the function."""
    path = folder / "model.xml"
    path.write_text(text, encoding="utf-8")

    def call(version: str, process: int, function: Any, *arguments: Any) -> Any:
        return plant(function, arguments) if version == NEW else function(*arguments)

    return upgrade_study(path.name, ModelRun(str(path), seconds=seconds), [OLD, NEW], RELEASES, call)


def changed_file(tmp_path: Path, old: str, new: str) -> Callable[[Any, tuple[Any, ...]], Any]:
    """A planted release that takes the model's file as if some text of it were another."""

    def plant(function: Any, arguments: tuple[Any, ...]) -> Any:
        request = arguments[0]
        other = tmp_path / "planted.xml"
        text = Path(request.path).read_text(encoding="utf-8")
        assert old in text
        other.write_text(text.replace(old, new), encoding="utf-8")
        return function(replace(request, path=str(other)), *arguments[1:])

    return plant


def hidden_fields(plant: Callable[[Any, tuple[Any, ...]], Any]) -> Callable[[Any, tuple[Any, ...]], Any]:
    """A planted release whose compiled model looks unchanged, as where an algorithm changed and no number did."""

    def call(function: Any, arguments: tuple[Any, ...]) -> Any:
        found = plant(function, arguments)
        return replace(found, fields={}) if function is release_calls.run_model else found

    return call


def test_the_same_release_twice_changes_nothing(tmp_path: Path) -> None:
    study = study_of(tmp_path, BALL, lambda function, arguments: function(*arguments))
    assert study.changes == ()
    assert headline(study) == "model.xml: the same to the last bit in 3.17.0 to 4.0.0, over 0.6 s from its own pose."


def test_compiled_number_is_named_with_its_element(tmp_path: Path) -> None:
    study = study_of(tmp_path, BALL, changed_file(tmp_path, 'name="skin" size="0.1"', 'name="skin" size="0.1001"'))
    (change,) = study.changes
    assert change.kind == COMPILED
    assert "geom_size of skin is 0.1001, was 0.1" in change.cause
    assert change.explained == ("Shapes collide otherwise.",)


def test_contact_that_changes_is_named_with_its_time(tmp_path: Path) -> None:
    # The ball touches after sqrt(2 0.2 m / g) = 0.202 s; with a margin of 10 mm some steps before.
    plant = hidden_fields(changed_file(tmp_path, 'name="skin"', 'name="skin" margin="0.01"'))
    (change,) = study_of(tmp_path, BALL, plant).changes
    assert change.kind == TERM
    assert "contacts change, 0 before, now 1 (between floor and skin)" in change.cause
    assert change.differs_at == pytest.approx(0.202, abs=0.01)
    assert change.body == "ball"


@pytest.mark.parametrize(
    ("old", "new", "term"),
    [
        ('axis="0 0 1"', 'axis="0 0 1" damping="0.1"', "springs, dampers and fluid at drop"),
        ('timestep="0.002"', 'timestep="0.002" gravity="0 0 -9.8"', "gravity and inertia at drop"),
        ('size="1 1 0.1"', 'size="1 1 0.1" solref="0.03 1"', "constraints at drop"),
    ],
)
def test_force_that_changes_is_named_with_its_joint(tmp_path: Path, old: str, new: str, term: str) -> None:
    (change,) = study_of(tmp_path, BALL, hidden_fields(changed_file(tmp_path, old, new))).changes
    assert change.kind == TERM
    assert f"the force of {term} changes" in change.cause
    assert change.explained == ("Shapes collide otherwise.",)


def one_bit(function: Any, arguments: tuple[Any, ...]) -> Any:
    """A planted release that rounds otherwise: whatever it is given, it begins one bit off."""
    if function in (release_calls.run_model, release_calls.advance_states):
        return function(*arguments, perturbed=True)
    return function(*arguments)


def test_chaos_is_told_from_a_change(tmp_path: Path) -> None:
    study = study_of(tmp_path, PENDULUM, one_bit, 20.0)
    (change,) = study.changes
    assert change.kind == ROUNDING
    assert "the motion is chaotic: the older release itself parts as well" in change.cause
    assert change.parted_at is not None
    assert change.explained == ("Bits.",)
    assert headline(study).startswith("model.xml: no release of 3.17.0 to 4.0.0 changed a term of it.")
    # Negative control: a damper of a millionth is no rounding, in the same motion.
    plant = hidden_fields(changed_file(tmp_path, 'name="elbow"', 'name="elbow" damping="1e-6"'))
    (change,) = study_of(tmp_path, PENDULUM, plant, 20.0).changes
    assert change.kind == TERM
    assert "dampers" in change.cause


def test_rounding_of_a_calm_motion_is_last_digits(tmp_path: Path) -> None:
    (change,) = study_of(tmp_path, BALL, one_bit, 0.1).changes
    assert change.last_digits
    assert change.cause == "from equal states both releases make equal steps"


def test_release_that_refuses_the_model_is_said_first(tmp_path: Path) -> None:
    plant = changed_file(tmp_path, "<option", '<option colour="red"')
    study = study_of(tmp_path, BALL, plant)
    (change,) = study.changes
    assert (change.kind, change.version) == (REFUSED, NEW)
    assert headline(study).startswith("model.xml: 4.0.0 does not load it: ")
    assert "colour" in headline(study)
    with pytest.raises(InvalidInput, match="colour"):
        study_of(tmp_path, BALL.replace("<option", '<option colour="red"'), lambda f, arguments: f(*arguments))


def test_costs_are_judged_beyond_the_spread_alone() -> None:
    def cost(ratio: float) -> ModelCost:
        noise = PairedTiming(1.0, 0.98, 1.02, 1.0, 1.0, 24)
        return ModelCost(NEW, PairedTiming(ratio, ratio - 0.01, ratio + 0.01, 1.0, 1.0, 24), noise)

    assert [cost(ratio).word for ratio in (0.9, 1.0, 1.02, 1.1)] == ["faster", *["within the spread"] * 2, "slower"]


def test_report_has_the_finding_and_its_cause(tmp_path: Path) -> None:
    study = study_of(tmp_path, BALL, changed_file(tmp_path, 'size="0.1"/>', 'size="0.1" mass="9"/>'))
    timing = PairedTiming(1.2, 1.1, 1.3, 1.0, 1.0, 24)
    study = replace(study, reference=OLD, costs=(ModelCost(NEW, timing, replace(timing, high=1.05)),))
    found = Findings(UPGRADES_REPORT, {"model": study})
    page = found.write(tmp_path / "report").read_text(encoding="utf-8")
    assert "body_mass of ball is 9" in page
    assert "slower" in found.text
    assert len(changes_table(study).rows) == len(costs_table(study).rows) == 1


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        (("pymunk", "MODEL"), "pymunk reads no MJCF"),
        (("mujoco", "MODEL", "saw-40rpm"), "scenes and models are compared apart"),
        (("mujoco", "saw-40rpm", "--seconds", "3"), "--seconds does not go with scenes"),
        (("mujoco", "MODEL", "--jobs", "2"), "--jobs does not go with a model"),
        (("mujoco", "model.mjb"), "a compiled model is of one release alone"),
    ],
)
def test_verb_refuses_what_does_not_go_together(tmp_path: Path, typed: tuple[str, ...], message: str) -> None:
    for name in ("model.xml", "model.mjb"):
        (tmp_path / name).write_text(BALL, encoding="utf-8")
    words = [str(tmp_path / word.replace("MODEL", "model.xml")) if "odel" in word.lower() else word for word in typed]
    told = CliRunner().invoke(cli, ["versions", *words], standalone_mode=False)
    assert isinstance(told.exception, InvalidInput)
    assert message in str(told.exception)


def test_state_sets_all_that_a_step_depends_on(tmp_path: Path) -> None:
    # Two steps from a state on its own are those of the run, to the last bit.
    path = tmp_path / "model.xml"
    path.write_text(BALL, encoding="utf-8")
    request = ModelRun(str(path), seconds=0.6)
    run = release_calls.run_model(request)
    starts: Mapping[str, Any] = {name: rows[:-1] for name, rows in run.states.items()}
    reached = release_calls.advance_states(request, starts, run.every)
    assert np.array_equal(reached, np.hstack([run.states["qpos"][1:], run.states["qvel"][1:]]))
