"""What settings gained for limits: short time constants that nothing raises, a rounded state; and keys that stayed."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import mujoco
import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW

from conrod import MuJoCoSettings, PymunkSettings, compare
from conrod.engines import engine_named
from conrod.engines.engine import LATER_FIELDS
from conrod.engines.mujoco import recorder
from conrod.engines.mujoco.dynamics import advance
from conrod.engines.mujoco.model import build
from conrod.engines.running import whole_run
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


# -- a rounded state -------------------------------------------------------------------------------------------------

ROUNDED = {
    "press, tuned": (PRESS, MuJoCoSettings.tuned(PRESS, STEPS)),
    "saw, two of CG": (SAW, replace(MuJoCoSettings.stock(SAW, STEPS), solver="CG", iterations=2)),
    "saw, gone wild": (SAW, replace(MuJoCoSettings.tuned(SAW, STEPS), refsafe=False, solref=(1e-3, 1.0))),
    "cam": (CAM, replace(MuJoCoSettings.tuned(CAM, 2000), cam_vertices=400)),
}


def is_single(values: Array) -> bool:
    with np.errstate(over="ignore"):
        return bool(np.array_equal(values, values.astype(np.float32), equal_nan=True))


@pytest.mark.parametrize("name", ROUNDED)
def test_coordinates_and_rates_are_rounded_after_each_step_and_the_clock_is_not(name: str) -> None:
    scene, settings = ROUNDED[name]
    found = states(scene, replace(settings, rounded_state=True))[0]
    assert is_single(found[1:, 1:])
    assert not is_single(found[:1, 1:])  # the start is exact
    assert not is_single(found[:, :1])
    assert not is_single(states(scene, settings)[0][1:, 1:])


@pytest.mark.parametrize("name", ["press, tuned", "saw, two of CG", "cam"])
def test_stepping_goes_on_from_the_rounded_state(name: str) -> None:
    scene, settings = ROUNDED[name]
    made = build(scene, settings)
    found, sensors = states(scene, replace(settings, rounded_state=True))
    whole = mujoco.MjData(made.model)
    for k in (0, 1, 5):
        # One step of the engine from the state that was recorded, the solver's first guess as it was then.
        mujoco.mj_setState(made.model, whole, found[k], recorder.STATE)
        whole.qacc_warmstart[:] = guess_before(made, scene, k)
        mujoco.mj_step(made.model, whole)
        assert np.concatenate([whole.qpos, whole.qvel]).astype(np.float32).tolist() == found[k + 1, 1:].tolist()
        assert whole.time == found[k + 1, 0]
        assert whole.sensordata.tobytes() == sensors[k].tobytes()


def guess_before(made: Any, scene: Any, steps: int) -> Array:
    data = mujoco.MjData(made.model)
    data.qpos[:], data.qvel[:] = made.start_state(scene, START)
    for _ in range(steps):
        mujoco.mj_step(made.model, data)
        data.qpos[:], data.qvel[:] = np.float32(data.qpos), np.float32(data.qvel)
    return np.array(data.qacc_warmstart)


@pytest.mark.parametrize("name", ROUNDED)
def test_but_for_the_rounding_it_is_the_same_run(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, settings = ROUNDED[name]
    expected = states(scene, settings)
    monkeypatch.setattr(recorder, "round_state", lambda data: None)
    found = states(scene, replace(settings, rounded_state=True))
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_array_equal(a, b)


def test_what_is_timed_rounds_too() -> None:
    scene, settings = ROUNDED["press, tuned"]
    bare = MUJOCO.stepper(scene, replace(settings, rounded_state=True))
    bare(150)
    rounded = replace(settings, rounded_state=True)
    expected = whole_run(MUJOCO, scene, rounded, 150 / STEPS, 0.0).bodies.position.instants
    assert bare.data.qpos[build(scene, settings).crank_dof] == expected.angle[-1]
    unrounded = MUJOCO.stepper(scene, settings)
    unrounded(150)
    assert not np.array_equal(unrounded.data.qpos, bare.data.qpos)


def test_rounding_costs_digits() -> None:
    settings = MuJoCoSettings.hardened(SAW, 1000)
    exact, rounded = (
        compare(whole_run(MUJOCO, SAW, replace(settings, rounded_state=single), 2.0, 0.0), SAW).worst("position")
        for single in (False, True)
    )
    assert exact < 1e-10
    assert 1e-7 < rounded < 1e-4


# -- said where settings are said ------------------------------------------------------------------------------------


def test_settings_to_paste_say_both() -> None:
    settings = MuJoCoSettings.tuned(SAW, STEPS)
    before, after = (MUJOCO.paste(SAW, s) for s in (settings, replace(settings, refsafe=False, rounded_state=True)))
    assert 'refsafe="disable"' in after
    assert "data.qvel[:] = data.qvel.astype(np.float32)" in after
    assert "refsafe" not in before
    assert "float32" not in before


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


@pytest.mark.parametrize(
    ("engine", "changes"),
    [("mujoco", {"refsafe": False}), ("mujoco", {"rounded_state": True}), ("pymunk", {"rounded_state": True})],
)
def test_a_later_field_that_differs_from_before_is_in_the_key(engine: str, changes: dict[str, Any]) -> None:
    settings = TUNED[engine]
    changed = replace(settings, **changes)
    assert RunCase("saw-40rpm", SAW, changed).key != RunCase("saw-40rpm", SAW, settings).key
    assert changed.as_dict() == settings.as_dict() | changes


@pytest.mark.parametrize("kind", [MuJoCoSettings, PymunkSettings])
def test_later_fields_have_by_default_what_all_runs_before_had(kind: Any) -> None:
    defaults = {field.name: field.default for field in fields(kind) if field.name in LATER_FIELDS}
    assert "rounded_state" in defaults
    assert defaults == {name: LATER_FIELDS[name] for name in defaults}
