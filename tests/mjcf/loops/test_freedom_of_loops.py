"""What drives determine, what they leave, and which bodies are links of the loops or carry them."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from four_bars import FRAME, GRASHOF, four_bar, rocker_pin

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mjcf.loops.results import LoopStudy, Question
from conrod.mjcf.loops.study import _Bench

TIMES = np.linspace(0.0, 1.0, 25)
LAW = {"crank": "60rpm"}


def bench(text: str, **drives: str) -> _Bench:
    return _Bench.of(mujoco.MjModel.from_xml_string(text), Question(LAW | drives))


def rocker_path() -> Array:
    """Of the rocker's pin, from the closed form, in the frame (T, 3)."""
    pins = [rocker_pin(GRASHOF, 1.0 + 2.0 * math.pi * time) for time in TIMES]
    return np.concatenate([pins, np.zeros((len(TIMES), 1))], axis=1)


def in_frame(points: Array) -> Array:
    place, quaternion = (np.array(part.split('"')[1].split(), dtype=float) for part in FRAME.split(" quat"))
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, quaternion / np.linalg.norm(quaternion))
    return (points - place) @ matrix.reshape(3, 3)


CART = (
    four_bar()
    .replace(
        '<body name="rocker" pos="0.35 0 0"',
        '<body name="cart" pos="0.35 0 0"><joint name="cart" type="slide" axis="1 0 0"/><geom size="0.01"/>'
        '<body name="rocker"',
    )
    .replace('<site name="C" pos="0.3 0 0"/></body>', '<site name="C" pos="0.3 0 0"/></body></body>')
)


def test_a_freedom_that_no_drive_takes_is_refused_by_name_or_held() -> None:
    with pytest.raises(InvalidInput, match=r"leaves 2, and 1 is driven: drive 1 more.*JOINT=hold.*coupler.*cart"):
        bench(CART)
    held = bench(CART, cart="hold")
    assert held.freedom.left == 2
    assert in_frame(held.machine.motion(TIMES).points["C"].position) == pytest.approx(rocker_path(), abs=1e-13)
    # And a drive that is not needed is too many.
    with pytest.raises(InvalidInput, match="1 of its 3 drives is too many: give 2 of crank, cart, rocker"):
        bench(CART, cart="hold", rocker="hold")


def free_coupler() -> str:
    """The four-bar with its coupler as a free body, pinned at both ends."""
    text = four_bar()
    start = text.index('<body name="coupler"')
    end = text.index("</body>", start) + len("</body>")
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    place, turn = (
        " ".join(map(repr, values.tolist())) for values in (data.body("coupler").xpos, data.body("coupler").xquat)
    )
    inertial = text[text.index("<inertial", start) : text.index("/>", text.index("<inertial", start)) + 2]
    body = f"""<body name="coupler" pos="{place}" quat="{turn}"><freejoint name="coupler"/>{inertial}
      <site name="B" pos="0.25 0 0"/><site name="A2" pos="0 0 0"/></body>"""
    made = text[:start] + text[end:].replace("</worldbody>", body + "</worldbody>")
    return made.replace("</equality>", '<connect name="second" site1="A" site2="A2"/></equality>')


def test_a_link_with_a_free_joint_is_a_link_and_spins_idly_about_itself() -> None:
    found = bench(free_coupler())
    assert found.machine.held == ()
    assert found.freedom.idle == ("coupler",)
    assert (found.freedom.freedom, found.freedom.rank, found.freedom.left) == (8, 6, 2)
    assert in_frame(found.machine.motion(TIMES).points["C"].position) == pytest.approx(rocker_path(), abs=1e-13)


def test_a_base_with_a_free_joint_is_held_with_all_that_is_in_no_loop() -> None:
    arm = '<body name="arm"><joint name="arm" axis="1 0 0"/><geom size="0.01" pos="0 0.1 0"/><site name="hand"/></body>'
    loose = '<body name="loose"><freejoint name="loose"/><geom size="0.1"/></body>'
    text = four_bar().replace(f'<body name="frame" {FRAME}>', f'<body name="frame" {FRAME}><freejoint name="base"/>'
                              f'<geom size="0.1" mass="2"/>{arm}')  # fmt: skip
    found = bench(text.replace("</worldbody>", loose + "</worldbody>"))
    assert set(found.machine.held) == {"base", "arm", "loose"}
    assert found.freedom.left == 1
    assert in_frame(found.machine.motion(TIMES).points["C"].position) == pytest.approx(rocker_path(), abs=1e-13)
    assert "hand" not in {point.name for point in found.points}


def test_a_loop_twice_is_redundant_and_a_loop_missing_is_a_freedom_more() -> None:
    twice = four_bar().replace("</equality>", '<connect name="again" site1="B" site2="C"/></equality>')
    assert bench(twice).freedom.redundant == {"pin": 1, "again": 3}
    assert bench(four_bar()).freedom.redundant == {"pin": 1}
    missing = twice.replace('site1="B" site2="C" />', 'site1="B" site2="C" active="false"/>')
    assert bench(missing).freedom.redundant == {"again": 1}


def test_sites_that_stand_still_are_refused_with_what_moves() -> None:
    still = four_bar().replace('<site name="A" pos="0.1 0 0"/>', '<site name="A"/>')
    found = _Bench.of(mujoco.MjModel.from_xml_string(still), Question(LAW, points=("A",)))
    with pytest.raises(InvalidInput, match=r"no judged point moves with these drives: A; --point NAME takes .*C"):
        found.studied("bar.xml", "bar", None)


@pytest.mark.slow
def test_contacts_and_limits_on_the_way_are_said_and_forces_not_compared_with_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("conrod.studies.frame.paired_timing.BLOCK_TIME", 2e-5)
    monkeypatch.setattr("conrod.mjcf.loops.study.FINER", (1,))
    monkeypatch.setattr("conrod.mjcf.loops.study.COARSER", (2,))
    wall = '<geom name="wall" size="1" pos="0.3 -0.2 0.5"/></worldbody>'
    ball = '<geom name="ball" size="0.03" pos="0.3 0 0" mass="0"/><site name="C"'
    text = four_bar().replace("</worldbody>", wall).replace('<site name="C"', ball).replace('contact="disable"', "")
    limited = four_bar().replace('<joint name="rocker"', '<joint name="rocker" range="-0.5 0.5"')
    for model, words in ((text, "parts touch on the way: wall and ball"), (limited, "rocker is up to")):
        study = studied(model)
        assert any(remark.startswith(words) for remark in study.remarks)
        assert study.unmodelled == ("contacts or limits on its way",)
        assert study.own.drives == study.own.reactions == {}
    assert studied(four_bar()).unmodelled == studied(four_bar()).remarks == ()


def studied(text: str) -> LoopStudy:
    model = mujoco.MjModel.from_xml_string(text)
    return _Bench.of(model, Question(LAW, seconds=0.05)).studied("bar.xml", "bar", None)
