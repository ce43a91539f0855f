"""What the stock preset has beside the engine as it comes, in words, and the engine with a motor of its own."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from conrod.cli.validate_scenes import print_verdicts
from conrod.engines import engine_named
from conrod.engines.engine import STOCK, Machine
from conrod.engines.mujoco.free_run import motor_run
from conrod.report.kind import Part
from conrod.report.validation.report import KIND
from conrod.runs.trajectory import Outcome
from conrod.scenes import Saw, ShearPress
from conrod.studies.validation.plan import Plan, validate_dynamic
from conrod.studies.validation.results import SceneStudy
from conrod.studies.validation.study import OWN_MOTOR, ValidationCase, validate_own_motor, validation_cases

CASES = [("mujoco", "stock", 1), ("mujoco", "tuned", 0), ("pymunk", "stock", 0)]


@pytest.mark.parametrize(("engine", "preset", "said"), CASES)
def test_the_drive_that_stock_mujoco_carries_is_named(
    engine: str, preset: str, said: int, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = Plan(steps_per_revolution=80, revolutions=1.0)
    found = validate_dynamic("saw", Saw(speed=4.0), engine_named(engine), preset, plan)
    print_verdicts([SceneStudy("saw", Saw(speed=4.0), (found,))])
    text = " ".join(capsys.readouterr().out.split())
    assert text.count("stock is MuJoCo as it comes, and a drive: a flywheel of") == said
    assert text.count("and a solver tolerance of 0") == said


# -- the engine's own motor beside it ----------------------------------------------------------------------------------

PRESS = ShearPress()  # whose crank turns clockwise


@pytest.fixture(scope="module", params=["mujoco", "pymunk"])
def both(request: pytest.FixtureRequest) -> SceneStudy:
    """Stock, and the engine with its own motor, of the press at its default steps."""
    engine, plan = engine_named(request.param), Plan(revolutions=1.0)
    asked, every = (
        validation_cases({"press": PRESS}, [engine], {engine.name: presets}, plan)
        for presets in ((STOCK,), tuple(engine.presets))
    )
    assert [case.preset for case in asked] == [None, STOCK]
    assert [case.preset for case in every][:3] == [None, STOCK, OWN_MOTOR]
    return SceneStudy("press", PRESS, tuple(case.run() for case in every[1:3]))


def test_the_flywheel_of_stock_changes_no_error_that_the_engines_own_motor_would_show(both: SceneStudy) -> None:
    stock, motor = both.results
    assert motor.completed, motor.reason
    for quantity in ("position", "acceleration"):
        assert 0.5 < motor.largest(quantity) / stock.largest(quantity) < 2.5  # type: ignore[operator]
    ripple = motor.drive["speed"]  # type: ignore[index]
    assert ripple is not None
    assert ripple < 0.01
    if motor.engine == "mujoco":  # it sags under load; conrod's drive would not
        assert ripple > 1e-4


def test_an_own_motor_is_measured_even_where_a_tolerance_is_asked_for(both: SceneStudy) -> None:
    motor = both.results[1]
    case = ValidationCase("press", PRESS, motor.engine, OWN_MOTOR, Plan(revolutions=1.0, tolerance={"position": 0.0}))
    assert (case.tolerance, motor.passed) == (None, None)
    assert case.ended(Outcome.CRASHED, "").passed is None
    # A preset has the key that it had; that of the motor is another.
    assert len({replace(case, preset=preset).key for preset in (STOCK, OWN_MOTOR)}) == 2


def test_page_and_console_say_what_drives_it(both: SceneStudy, capsys: pytest.CaptureFixture[str]) -> None:
    print_verdicts([both])
    console = " ".join(capsys.readouterr().out.split())
    actuator = {"mujoco": "a velocity actuator (kv 1000, integrator implicitfast)", "pymunk": "a SimpleMotor"}
    said = f"its crank driven by {actuator[both.results[1].engine]}, as a user would set it up; its speed is off by"
    page = KIND.page(Part("press", both, "", "", {"figures": ()})).text
    for text in (console, page):
        assert said in text
        assert ("a flywheel of 1e14 kg m²" in text) == (both.results[1].engine == "mujoco")
        assert "own motor" in text


def test_a_motor_that_turns_the_wrong_way_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    # Negative control: asked for the rate of the body, which turns against the crank angle.
    engine = engine_named("mujoco")

    def backwards(machine: Machine, *rest: Any) -> Any:
        return motor_run(SimpleNamespace(kinematics=machine.kinematics, speed=-machine.speed), *rest)  # type: ignore[arg-type]

    monkeypatch.setattr(type(engine), "motor_run", staticmethod(backwards))
    assert validate_own_motor("press", PRESS, engine, Plan(revolutions=1.0)).outcome == Outcome.STALLED.slug
