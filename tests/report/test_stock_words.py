"""What the stock preset has beside the engine as it comes, in words."""

from __future__ import annotations

import pytest

from conrod.cli.validate_scenes import verdicts
from conrod.engines import engine_named
from conrod.report.terminal import tell
from conrod.scenes import Saw
from conrod.studies.validation.plan import Plan, validate_dynamic
from conrod.studies.validation.results import SceneStudy

CASES = [("mujoco", "stock", 1), ("mujoco", "tuned", 0), ("pymunk", "stock", 0)]


@pytest.mark.parametrize(("engine", "preset", "said"), CASES)
def test_the_drive_that_stock_mujoco_carries_is_named(
    engine: str, preset: str, said: int, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = Plan(steps_per_revolution=80, revolutions=1.0)
    found = validate_dynamic("saw", Saw(speed=4.0), engine_named(engine), preset, plan)
    tell(verdicts([SceneStudy("saw", Saw(speed=4.0), (found,))]))
    text = " ".join(capsys.readouterr().out.split())
    assert text.count("stock is MuJoCo as it comes, and a drive: a flywheel of") == said
    assert text.count("and a solver tolerance of 0") == said
