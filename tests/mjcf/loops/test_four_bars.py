"""Four-bars in space: followed on their branch as far as they reach, refused where they are not, and their freedoms."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from four_bars import FRAME, GRASHOF, driven, four_bar, rocker_pin, start_angles
from scipy.spatial.transform import Rotation

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import motion as motion_module
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.loop_results import LoopRequest, LoopStudy
from conrod.models.loops.study import _LoopBench

LAW = {"crank": "60rpm"}


def branch_error(found: DrivenTree, lengths: tuple[float, ...], times: Array, branch: float = 1.0) -> float:
    """Largest deviation of the rocker's angle from the closed form [rad]."""
    motion = found.motion(times)
    turns, rocker = motion.coordinates[0], motion.coordinates[2]
    exact = np.array([start_angles(lengths, turn, branch)[2] for turn in turns])
    return float(np.abs(np.exp(1j * rocker) - np.exp(1j * exact)).max())


TIMES = np.linspace(0.0, 1.0, 37)


# The pose nearest to the reference in its other coordinates may be on the other branch, 170 degrees away.
@pytest.mark.parametrize(("law", "ends"), [("60rpm", (math.degrees(1.0), math.degrees(1.0) + 360.0)),
                                           ("move:240deg,300deg,1s", (240.0, 300.0))])  # fmt: skip
@pytest.mark.parametrize("branch", [1.0, -1.0])
def test_loop_stays_on_its_branch_up_to_the_start_of_a_law(branch: float, law: str, ends: tuple[float, float]) -> None:
    found = driven(four_bar(branch=branch), {"crank": law})
    assert branch_error(found, GRASHOF, TIMES, branch) < 1e-13
    assert branch_error(found, GRASHOF, TIMES, -branch) > 0.5  # negative control
    assert np.degrees(found.motion(TIMES).coordinates[0, [0, -1]]) == pytest.approx(ends)


# -- where it ends -----------------------------------------------------------------------------------------------------


def test_crank_is_refused_with_its_last_angle_when_stopped() -> None:
    lengths = (0.2, 0.15, 0.15, 0.3)  # reaches until coupler and rocker are in line
    limit = math.degrees(math.acos((0.2**2 + 0.3**2 - 0.3**2) / (2 * 0.2 * 0.3)))
    with pytest.raises(InvalidInput, match="it goes no further than with crank at ") as refused:
        driven(four_bar(lengths, crank=0.5), LAW)
    words = str(refused.value)
    assert float(words.split("crank at ")[1].split(" deg", maxsplit=1)[0]) == pytest.approx(limit, abs=0.01)
    assert "a dead centre, or its loops reach no further" in words
    # Up to there it goes.
    span = f"move:{math.degrees(0.5)!r}deg,{limit - 0.1!r}deg,1s"
    assert branch_error(driven(four_bar(lengths, crank=0.5), {"crank": span}), lengths, TIMES) < 1e-11


def test_a_gap_in_the_cranks_turn_is_not_leapt_over() -> None:
    # Two thirds of a degree, or a fiftieth, on both sides of 0 the coupler is too long for it.
    for longer in (1e-5, 1e-8):
        with pytest.raises(InvalidInput, match="it goes no further than with crank at 359"):
            driven(four_bar((0.1, 0.3 + longer, 0.1, 0.3), crank=math.pi), LAW)


def test_samples_that_do_not_close_are_an_error_and_no_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    # Negative control of the whole: with too few steps of Newton's method it says so.
    found = driven(four_bar(), LAW)
    monkeypatch.setattr(motion_module, "MAX_NEWTON_STEPS", 1)
    with pytest.raises(InvalidInput, match="its loops do not close with crank at"):
        found.motion(np.linspace(0.0, 1.0, 11))


# -- freedoms --------------------------------------------------------------------------------------------------------


def bench(text: str, **drives: str) -> _LoopBench:
    return _LoopBench.from_request(mujoco.MjModel.from_xml_string(text), LoopRequest(LAW | drives))


def rocker_path() -> Array:
    """Of the rocker's pin, from the closed form, in the frame (T, 3)."""
    pins = [rocker_pin(GRASHOF, 1.0 + 2.0 * math.pi * time) for time in TIMES]
    return np.concatenate([pins, np.zeros((len(TIMES), 1))], axis=1)


def in_frame(points: Array) -> Array:
    place, quaternion = (np.array(part.split('"')[1].split(), dtype=float) for part in FRAME.split(" quat"))
    return (points - place) @ Rotation.from_quat(np.roll(quaternion, -1)).as_matrix()


def free_coupler() -> str:
    """The four-bar with its coupler as a free body, pinned at both ends."""
    text = four_bar()
    coupler = text[text.index('<body name="coupler"') : text.index("</body>") + len("</body>")]
    data = mujoco.MjData(model := mujoco.MjModel.from_xml_string(text))
    mujoco.mj_forward(model, data)
    place, turn = (" ".join(map(repr, v.tolist())) for v in (data.body("coupler").xpos, data.body("coupler").xquat))
    inertial = coupler[coupler.index("<inertial") : coupler.index("/>", coupler.index("<inertial")) + 2]
    body = f"""<body name="coupler" pos="{place}" quat="{turn}"><freejoint name="coupler"/>{inertial}
      <site name="B" pos="0.25 0 0"/><site name="A2" pos="0 0 0"/></body>"""
    made = text.replace(coupler, "").replace("</worldbody>", body + "</worldbody>")
    return made.replace("</equality>", '<connect name="second" site1="A" site2="A2"/></equality>')


def test_free_joint_link_is_a_link_that_spins_idly() -> None:
    found = bench(free_coupler())
    assert found.machine.held == ()
    assert found.freedom.idle == ("coupler",)
    assert (found.freedom.freedom, found.freedom.rank, found.freedom.remaining_dof) == (8, 6, 2)
    assert in_frame(found.machine.motion(TIMES).points["C"].position) == pytest.approx(rocker_path(), abs=1e-13)


def test_free_base_is_held_with_all_bodies_outside_loops() -> None:
    arm = '<body name="arm"><joint name="arm" axis="1 0 0"/><geom size="0.01" pos="0 0.1 0"/><site name="hand"/></body>'
    loose = '<body name="loose"><freejoint name="loose"/><geom size="0.1"/></body>'
    text = four_bar().replace(f'<body name="frame" {FRAME}>', f'<body name="frame" {FRAME}><freejoint name="base"/>'
                              f'<geom size="0.1" mass="2"/>{arm}')  # fmt: skip
    found = bench(text.replace("</worldbody>", loose + "</worldbody>"))
    assert set(found.machine.held) == {"base", "arm", "loose"}
    assert found.freedom.remaining_dof == 1
    assert in_frame(found.machine.motion(TIMES).points["C"].position) == pytest.approx(rocker_path(), abs=1e-13)
    assert "hand" not in {point.name for point in found.points}


def test_double_loop_is_redundant_and_missing_loop_adds_freedom() -> None:
    twice = four_bar().replace("</equality>", '<connect name="again" site1="B" site2="C"/></equality>')
    assert bench(twice).freedom.redundant == {"pin": 1, "again": 3}
    assert bench(four_bar()).freedom.redundant == {"pin": 1}
    missing = twice.replace('site1="B" site2="C" />', 'site1="B" site2="C" active="false"/>')
    assert bench(missing).freedom.redundant == {"again": 1}


@pytest.mark.slow
def test_contacts_and_limits_are_named_and_suspend_force_checks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)
    monkeypatch.setattr("conrod.models.loops.study.FINER", ())
    monkeypatch.setattr("conrod.models.loops.study.COARSER", (2,))
    wall = '<geom name="wall" size="1" pos="0.3 -0.2 0.5"/></worldbody>'
    ball = '<geom name="ball" size="0.03" pos="0.3 0 0" mass="0"/><site name="C"'
    text = four_bar().replace("</worldbody>", wall).replace('<site name="C"', ball).replace('contact="disable"', "")
    limited = four_bar().replace('<joint name="rocker"', '<joint name="rocker" range="-0.5 0.5"')
    for model, words, acting in (
        (text, "parts touch on the way: ball and wall", "contact of ball and wall"),
        (limited, "rocker is up to", "the limit of joint rocker"),
    ):
        study = studied(model)
        assert any(remark.startswith(words) for remark in study.remarks)
        assert study.unmodelled == (acting,)
        assert study.driven_run.drives == study.driven_run.reactions == {}
    assert studied(four_bar()).unmodelled == studied(four_bar()).remarks == ()


def studied(text: str) -> LoopStudy:
    model = mujoco.MjModel.from_xml_string(text)
    return _LoopBench.from_request(model, LoopRequest(LAW, seconds=0.05)).study("bar.xml", "bar", None)
