"""What settings gained for limits: short time constants that nothing raises; and keys that stayed."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import pytest
from catalogue import SAW

from conrod import MuJoCoSettings, PymunkSettings
from conrod.engines import engine_named
from conrod.engines.engine import LATER_FIELDS
from conrod.engines.mujoco.dynamics import advance
from conrod.engines.mujoco.model import build
from conrod.exact.motion import Array
from conrod.studies.frame.run import RunCase

MUJOCO: Any = engine_named("mujoco")
STEPS, START = 200, 0.7


def states(scene: Any, settings: MuJoCoSettings, steps: int = 150) -> tuple[Array, Array]:
    """All states and sensor data of a run."""
    return advance(build(scene, settings), scene, settings, steps, START)[1:]


# -- short time constants --------------------------------------------------------------------------------------------


def in_steps(steps: float, refsafe: bool) -> MuJoCoSettings:
    settings = MuJoCoSettings.tuned(SAW, STEPS)
    return replace(settings, solref=(steps * settings.timestep, 1.0), refsafe=refsafe)


def test_guarded_time_constants_below_two_steps_are_two_steps() -> None:
    two, one = states(SAW, in_steps(2.0, refsafe=True)), states(SAW, in_steps(1.0, refsafe=True))
    assert one[0].tobytes() == two[0].tobytes()


def test_unguarded_ones_are_what_they_are() -> None:
    two, one = states(SAW, in_steps(2.0, refsafe=False)), states(SAW, in_steps(1.0, refsafe=False))
    assert two[0].tobytes() == states(SAW, in_steps(2.0, refsafe=True))[0].tobytes()
    assert one[0].tobytes() != two[0].tobytes()


# -- said where settings are said ------------------------------------------------------------------------------------


def test_settings_to_paste_say_so() -> None:
    settings = MuJoCoSettings.tuned(SAW, STEPS)
    before, after = (MUJOCO.paste(SAW, s) for s in (settings, replace(settings, refsafe=False)))
    assert 'refsafe="disable"' in after
    assert "refsafe" not in before


# Of cells at their engines' versions 4.0.0 and 7.3.1, from before the settings gained the fields of `LATER_FIELDS`.
KEYS = {
    "mujoco": "7bceac66628836f91948ec631de5e8fa",
    "pymunk": "13e4442645d01eaa235fa7295eafec0a",
}
TUNED: dict[str, Any] = {
    "mujoco": MuJoCoSettings.tuned(SAW, 1000),
    "pymunk": PymunkSettings.tuned(SAW, 1000),
}


@pytest.fixture
def versions(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, version in (("mujoco", "4.0.0"), ("pymunk", "7.3.1")):
        monkeypatch.setattr(type(engine_named(name)), "version", version)


@pytest.mark.usefixtures("versions")
@pytest.mark.parametrize("engine", KEYS)
def test_keys_of_earlier_results_are_what_they_were(engine: str) -> None:
    assert RunCase("saw-40rpm", SAW, TUNED[engine]).key == KEYS[engine]


def test_a_later_field_that_differs_from_before_is_in_the_key() -> None:
    settings, changes = TUNED["mujoco"], {"refsafe": False}
    changed = replace(settings, **changes)
    assert RunCase("saw-40rpm", SAW, changed).key != RunCase("saw-40rpm", SAW, settings).key
    assert changed.as_dict() == settings.as_dict() | changes


def test_later_fields_have_by_default_what_all_runs_before_had() -> None:
    assert {field.name: field.default for field in fields(MuJoCoSettings) if field.name in LATER_FIELDS} == LATER_FIELDS
