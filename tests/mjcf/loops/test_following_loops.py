"""Loops are followed on their branch as far as they reach, from poses near and far, and refused where they are not."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from four_bars import GRASHOF, four_bar, start_angles

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import motion as motion_module
from conrod.exact.space.laws import law_of
from conrod.exact.space.mobility import check_drives
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.loops.reading import tree_of

FAR = 'pos="30 -40 0"'


def machine(text: str, law: str = "60rpm", start: Array | None = None, seconds: float = 1.0, **more: str) -> DrivenTree:
    """After it went along its motion."""
    model = mujoco.MjModel.from_xml_string(text)
    tree = tree_of(model, model.qpos0 if start is None else start)
    by_name = {joint.name: joint for joint in tree.joints}
    laws = {"crank": law} | more
    made = DrivenTree(
        tree, {j: law_of(one, by_name[j].unit, tree.start[by_name[j].coordinate], j) for j, one in laws.items()}
    )
    there = made.assembled()
    check_drives(made, there)
    made.go(there, seconds)
    return made


def branch_error(found: DrivenTree, lengths: tuple[float, ...], times: Array, branch: float = 1.0) -> float:
    """Largest deviation of the rocker's angle from the closed form [rad]."""
    motion = found.motion(times)
    turns, rocker = motion.coordinates[0], motion.coordinates[2]
    exact = np.array([start_angles(lengths, turn, branch)[2] for turn in turns])
    return float(np.abs(np.exp(1j * rocker) - np.exp(1j * exact)).max())


TIMES = np.linspace(0.0, 1.0, 37)


@pytest.mark.parametrize("branch", [1.0, -1.0])
def test_a_loop_is_followed_on_the_branch_that_it_starts_on(branch: float) -> None:
    found = machine(four_bar(branch=branch))
    assert branch_error(found, GRASHOF, TIMES, branch) < 1e-13
    assert branch_error(found, GRASHOF, TIMES, -branch) > 0.5  # negative control


@pytest.mark.parametrize("branch", [1.0, -1.0])
def test_a_law_that_begins_elsewhere_is_gone_to_on_the_branch(branch: float) -> None:
    # The pose nearest to the reference in its other coordinates may be on the other branch, 170 degrees away.
    found = machine(four_bar(branch=branch), law="move:240deg,300deg,1s")
    assert branch_error(found, GRASHOF, TIMES, branch) < 1e-13
    assert np.degrees(found.motion(TIMES).coordinates[0, [0, -1]]) == pytest.approx([240.0, 300.0])


def test_a_fast_drive_beside_a_slow_one_is_followed_and_refused_where_it_repeats_too_often() -> None:
    slide = '<body name="cart"><joint name="cart" type="slide"/><geom size="0.1"/><site name="S"/></body></worldbody>'
    text = four_bar().replace("</worldbody>", slide)
    found = machine(text, cart="sine:5mm,2Hz")
    assert found.motion(np.array([0.375])).points["S"].acceleration[0, 2] == pytest.approx(5e-3 * (4.0 * math.pi) ** 2)
    assert branch_error(found, GRASHOF, TIMES) < 1e-13
    with pytest.raises(InvalidInput, match=r"4 s: its fastest drive repeats too often .*: 0\.417 s at most"):
        machine(text, seconds=4.0, cart="sine:5mm,1kHz")


# -- where it ends -----------------------------------------------------------------------------------------------------


def test_a_crank_that_cannot_turn_is_refused_with_the_angle_that_it_reaches() -> None:
    lengths = (0.2, 0.15, 0.15, 0.3)  # reaches until coupler and rocker are in line
    limit = math.degrees(math.acos((0.2**2 + 0.3**2 - 0.3**2) / (2 * 0.2 * 0.3)))
    with pytest.raises(InvalidInput, match="it goes no further than with crank at ") as refused:
        machine(four_bar(lengths, crank=0.5))
    words = str(refused.value)
    assert float(words.split("crank at ")[1].split(" deg", maxsplit=1)[0]) == pytest.approx(limit, abs=0.01)
    assert "a dead centre, or its loops reach no further" in words
    # Up to there it goes.
    span = f"move:{math.degrees(0.5)!r}deg,{limit - 0.1!r}deg,1s"
    assert branch_error(machine(four_bar(lengths, crank=0.5), law=span), lengths, TIMES) < 1e-11


def test_a_gap_in_the_cranks_turn_is_not_leapt_over() -> None:
    # Two thirds of a degree, or a fiftieth, on both sides of 0 the coupler is too long for it.
    for longer in (1e-5, 1e-8):
        with pytest.raises(InvalidInput, match="it goes no further than with crank at 359"):
            machine(four_bar((0.1, 0.3 + longer, 0.1, 0.3), crank=math.pi))


# -- loops that contradict each other ----------------------------------------------------------------------------------


@pytest.mark.parametrize("frame", ["", FAR])
def test_a_loop_that_is_short_by_a_centimetre_is_open_wherever_it_stands(frame: str) -> None:
    shorter = four_bar(frame=frame).replace('<site name="C" pos="0.3 0 0"/>', '<site name="C" pos="0.3 0 0.01"/>')
    assert machine(four_bar(frame=frame)).misfit < 1e-13
    with pytest.raises(InvalidInput, match=r"its loops do not close with crank at 57\.296 deg: pin stays open by"):
        machine(shorter)


def test_samples_that_do_not_close_are_an_error_and_no_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    # Negative control of the whole: with too few steps of Newton's method it says so.
    found = machine(four_bar())
    monkeypatch.setattr(motion_module, "NEWTON_STEPS", 1)
    with pytest.raises(InvalidInput, match="its loops do not close with crank at"):
        found.motion(np.linspace(0.0, 1.0, 11))
