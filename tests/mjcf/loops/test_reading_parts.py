"""What a model's file switches off, limits or leaves out is read as such, and a refusal says what it is of."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import pytest
from four_bars import four_bar, key, start_angles

from conrod.errors import InvalidInput
from conrod.exact.space import SpatialTree
from conrod.exact.space.mobility import Mobility
from conrod.mjcf.equalities import (
    close_loops,
    closure_name,
    constraint_violations,
    disabling_flag,
    equality_kind,
    handle_indices,
    handle_words,
    inactive_closures,
    inactive_words,
    is_handle,
    measures_angles,
    mocap_of,
    row_equalities,
)
from conrod.mjcf.loop_results import LoopRequest
from conrod.mjcf.reading import check_rigid, duration, judged_points, laws_of, machine_tree, tree_of

# A crank, a ball and a slide; a fixed tendon, a spatial one, and a closure of each kind.
MACHINE = """<mujoco><compiler angle="radian"/><option gravity="1 2 -9.81"><flag {flag}/></option>
<worldbody>
  <body name="crank" pos="0.1 0.2 0.3"><joint name="crank" axis="0 0 1" range="-1 2" {limited} ref="0.25" damping="0.5"
    stiffness="3" springref="0.75" armature="0.01"/>
    <inertial pos="0.01 0.02 0.03" mass="2" diaginertia="0.1 0.2 0.25" quat="0 0 1 1"/>
    <site name="tip" pos="0.5 0 0"/>
    <body name="bob" pos="0.5 0 0"><joint name="swivel" type="ball" range="0 1" {limited}/><geom size="0.02"/></body>
  </body>
  <body name="slider" pos="1 0 0"><joint name="slide" type="slide" axis="1 0 0" range="-0.1 0.4" {limited}/>
    <geom size="0.02"/><site pos="0 0 0.1"/></body>
  <body name="fixed" pos="3 0 0"><geom size="0.02"/><site name="anchor"/></body>
  <body name="hand" mocap="true" pos="1 2 3" quat="0 1 0 0"><body name="palm"><geom size="0.01"/></body></body>
  <body name="held" pos="1 2 3"><freejoint name="float"/><geom size="0.02"/></body>
</worldbody>
<tendon><fixed name="both"><joint joint="crank" coef="2"/><joint joint="slide" coef="-0.5"/></fixed>
  <fixed name="turns"><joint joint="crank" coef="2"/></fixed>
  <spatial name="rope"><site site="tip"/><site site="anchor"/></spatial></tendon>
<equality>{equality}</equality>{more}</mujoco>"""


def compiled(equality: str = "", flag: str = "", limited: str = "", more: str = "") -> mujoco.MjModel:
    text = MACHINE.format(equality=equality, flag=flag, limited=limited, more=more)
    return mujoco.MjModel.from_xml_string(text)


def read(model: mujoco.MjModel) -> SpatialTree:
    return tree_of(model, model.qpos0)


# -- what is switched off ----------------------------------------------------------------------------------------------

BELT = '<joint name="belt" joint1="crank" joint2="slide"/>'
OFF = BELT.replace("belt", "loose").replace("<joint", '<joint active="false"')


def test_closures_that_do_not_act_at_first_are_not_in_the_tree() -> None:
    model = compiled(BELT + OFF)
    assert [one.name for one in read(model).closures] == ["belt"]
    assert inactive_closures(model) == ("loose",)
    assert inactive_words(model) == 'closure loose is inactive (active="false")'
    # The compiled model and not the file counts.
    model.eq_active0[:] = 0, 1
    assert [one.name for one in read(model).closures] == ["loose"]
    assert inactive_closures(model) == ("belt",)
    model.eq_active0[:] = 0
    assert inactive_words(model) == 'closures belt, loose are inactive (active="false")'
    assert inactive_words(compiled(BELT)) == ""
    assert disabling_flag(model) == ""


@pytest.mark.parametrize("flag", ["equality", "constraint"])
def test_a_flag_switches_all_closures_and_handles_off(flag: str) -> None:
    model = compiled(BELT + '<weld name="grip" body1="hand" body2="held"/>', f'{flag}="disable"')
    assert read(model).closures == ()
    assert disabling_flag(model) == flag
    assert inactive_closures(model) == ("belt", "grip")
    assert inactive_words(model) == f'closures belt, grip are inactive (<flag {flag}="disable"/>)'
    assert handle_indices(model) == ()
    assert inactive_words(compiled(BELT, f'{flag}="disable"')) == (
        f'closure belt is inactive (<flag {flag}="disable"/>)'
    )


def test_numbers_of_bodies_and_joints_are_those_of_the_file() -> None:
    model = compiled()
    tree = read(model)
    crank = next(joint for joint in tree.joints if joint.name == "crank")
    assert (crank.kind, crank.body, crank.coordinate, crank.rate) == ("hinge", 1, 0, 0)
    assert (crank.reference, crank.armature, crank.damping) == (0.25, 0.01, 0.5)
    assert (crank.stiffness, crank.spring) == (3.0, 0.75)
    assert [(joint.name, joint.kind) for joint in tree.joints] == [
        ("crank", "hinge"), ("swivel", "ball"), ("slide", "slide"), ("float", "free"),
    ]  # fmt: skip
    body = tree.bodies[1]
    assert (body.name, body.parent, body.mass, body.centre.tolist()) == ("crank", 0, 2.0, [0.01, 0.02, 0.03])
    # Half a turn about (0, 1, 1) exchanges y and z.
    assert body.inertia == pytest.approx(np.diag([0.1, 0.25, 0.2]), abs=1e-15)
    assert tree.gravity.tolist() == [1.0, 2.0, -9.81]
    assert tree.start.tolist() == model.qpos0.tolist()
    # Points are frames of what moves, and sites on it; a site without a name has its number.
    assert {name: (point.body, point.offset.tolist()) for name, point in tree.points.items()} == {
        "crank": (1, [0.0, 0.0, 0.0]), "bob": (2, [0.0, 0.0, 0.0]), "slider": (3, [0.0, 0.0, 0.0]),
        "held": (7, [0.0, 0.0, 0.0]), "tip": (1, [0.5, 0.0, 0.0]), "site 1": (3, [0.0, 0.0, 0.1]),
    }  # fmt: skip
    hand = tree.bodies[5]
    assert hand.place.tolist() == [1.0, 2.0, 3.0]
    assert hand.turn == pytest.approx(np.diag([1.0, -1.0, -1.0]))
    assert tree.unmodelled == ()


@pytest.mark.parametrize(("flag", "field", "without"), [
    ("damper", "damping", 0.0), ("spring", "stiffness", 0.0), ("limit", "range", None), ("constraint", "range", None),
])  # fmt: skip
def test_a_flag_switches_what_a_joint_has_off(flag: str, field: str, without: float | None) -> None:
    values = {"damping": 0.5, "stiffness": 3.0, "range": (-1.0, 2.0)}
    before, after = (read(compiled(flag=words)).joints[0] for words in ("", f'{flag}="disable"'))
    assert getattr(before, field) == values[field]
    assert getattr(after, field) == without
    # Nothing else is.
    assert all(getattr(after, other) == value for other, value in values.items() if other != field)


def test_gravity_that_is_off_is_none() -> None:
    assert read(compiled(flag='gravity="disable"')).gravity.tolist() == [0.0, 0.0, 0.0]


def test_limits_are_of_limited_hinges_and_slides() -> None:
    ranges = {joint.name: joint.range for joint in read(compiled(limited='limited="true"')).joints}
    assert ranges == {"crank": (-1.0, 2.0), "swivel": None, "slide": (-0.1, 0.4), "float": None}
    unlimited = read(compiled(limited='limited="false"')).joints
    assert {joint.range for joint in unlimited} == {None}


@pytest.mark.parametrize(("more", "unmodelled"), [
    ('<actuator><position joint="crank" kp="5" armature="0.1"/></actuator>', ("armatures of actuators",)),
    ('<tendon><fixed armature="0.2"><joint joint="crank" coef="1"/></fixed></tendon>', ("armatures of tendons",)),
    ('<actuator><motor joint="crank"/></actuator>', ()),
])  # fmt: skip
def test_inertias_that_the_exact_forces_lack_are_named(more: str, unmodelled: tuple[str, ...]) -> None:
    try:
        model = compiled(more=more)
    except ValueError:
        pytest.skip("this release of MuJoCo has no such armature")
    assert read(model).unmodelled == unmodelled


# -- closures ----------------------------------------------------------------------------------------------------------


def test_couplings_are_sums_of_joints_about_their_references() -> None:
    poly = 'polycoef="0.1 0.2 0.3 0.4 0.5"'
    model = compiled(
        f'<joint name="a" joint1="crank" joint2="slide" {poly}/><joint name="b" joint1="slide" {poly}/>'
        f'<tendon name="c" tendon1="both" tendon2="turns" {poly}/><tendon name="d" tendon1="turns"/>'
    )
    crank, slide = (int(model.joint(name).dofadr[0]) for name in ("crank", "slide"))
    a, b, c, d = read(model).closures
    assert (a.kind, a.sums, a.references) == ("joint", ({crank: 1.0}, {slide: 1.0}), (0.25, 0.0))
    assert (b.kind, b.sums, b.references) == ("joint", ({slide: 1.0}, {}), (0.0, 0.0))
    assert (c.kind, c.sums) == ("tendon", ({crank: 2.0, slide: -0.5}, {crank: 2.0}))
    assert c.references == (0.5, 0.5)  # 2 x 0.25
    assert (d.sums, d.references) == (({crank: 2.0}, {}), (0.5, 0.0))
    assert a.polynomial == b.polynomial == c.polynomial == (0.1, 0.2, 0.3, 0.4, 0.5)
    assert {one.points for one in (a, b, c, d)} == {()}
    assert [measures_angles(model, k) for k in range(4)] == [True, False, False, True]


def test_ends_of_connects_and_welds_are_on_their_bodies() -> None:
    model = compiled(
        '<connect name="a" body1="crank" body2="slider" anchor="0.1 0.2 0.3"/>'
        '<weld name="b" body1="crank" body2="slider" anchor="0.4 0.5 0.6" relpose="0.01 0.02 0.03 0 0 0 1"/>'
        '<connect name="c" site1="tip" site2="anchor"/><weld name="d" site1="anchor" site2="tip"/>'
    )
    a, b, c, d = read(model).closures
    assert [(one.kind, [point.body for point in one.points]) for one in (a, b, c, d)] == [
        ("connect", [1, 3]), ("weld", [1, 3]), ("connect", [1, 4]), ("weld", [4, 1]),
    ]  # fmt: skip
    # The crank stands at (0.1, 0.2, 0.3), the slider at (1, 0, 0).
    assert a.points[0].offset == pytest.approx([0.1, 0.2, 0.3])
    assert a.points[1].offset == pytest.approx([-0.8, 0.4, 0.6])
    assert b.points[1].offset == pytest.approx([0.4, 0.5, 0.6])
    assert b.points[0].offset == pytest.approx([0.01, 0.02, 0.03])  # where the anchor is to be, as MuJoCo takes it
    assert b.turn == pytest.approx(np.diag([-1.0, -1.0, 1.0]))
    assert (a.turn, c.turn) == (None, None)
    assert d.turn == pytest.approx(np.eye(3))
    assert [one.offset.tolist() for one in c.points] == [[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]]
    assert [measures_angles(model, k) for k in range(4)] == [False] * 4


def test_nameless_closure_is_called_by_its_number_and_ends() -> None:
    model = compiled(
        '<connect body1="crank" body2="slider" anchor="0 0 0"/><connect site1="tip" site2="anchor"/>'
        '<joint joint1="crank" joint2="slide"/><joint joint1="slide"/><tendon tendon1="both"/><weld body1="crank"/>'
    )
    assert [closure_name(model, k) for k in range(6)] == [
        "equality 0 (crank to slider)", "equality 1 (crank to fixed)", "equality 2 (crank to slide)",
        "equality 3 (slide)", "equality 4 (both)", "equality 5 (crank to world)",
    ]  # fmt: skip


@pytest.mark.parametrize("tendons", ['tendon1="rope"', 'tendon1="both" tendon2="rope"'])
def test_a_coupling_of_a_tendon_through_sites_is_refused(tendons: str) -> None:
    with pytest.raises(InvalidInput) as told:
        read(compiled(f'<tendon name="p" {tendons}/>'))
    assert str(told.value) == (
        "p: its tendon runs through sites; only fixed tendons, sums of joints, are closures here"
    )


def test_a_coupling_of_a_ball_is_refused() -> None:
    model = compiled(BELT)
    model.eq_obj2id[0] = model.joint("swivel").id  # which the compiler itself refuses
    with pytest.raises(InvalidInput, match=r"^belt: it couples swivel, a ball joint$"):
        read(model)


# -- how far closures are open -----------------------------------------------------------------------------------------


def test_closures_are_open_by_lengths_and_angles_times_extent() -> None:
    model = compiled(
        '<joint name="hinge" joint1="crank" joint2="slide" polycoef="0 3 0 0 0"/><joint name="slide" joint1="slide"/>'
        '<connect name="pin" body1="slider" body2="fixed" anchor="0 0 0"/><tendon name="turns" tendon1="turns"/>'
        '<tendon name="both" tendon1="both"/><weld name="grip" body1="held" anchor="1 2 3" torquescale="0.5"/>'
        f"{OFF}"
    )
    data = mujoco.MjData(model)
    data.qpos[model.joint("crank").qposadr[0]] = 0.25 + 0.2
    data.qpos[model.joint("slide").qposadr[0]] = 0.1
    held = model.joint("float").qposadr[0]
    data.qpos[held : held + 3] += [0.0, 0.03, 0.04]
    data.qpos[held + 3 : held + 7] = math.cos(0.15), 0.0, 0.0, math.sin(0.15)  # 0.3 rad about z
    mujoco.mj_fwdPosition(model, data)
    assert row_equalities(data).tolist() == [0, 1, 2, 2, 2, 3, 4, 5, 5, 5, 5, 5, 5]
    violations = constraint_violations(model, data, 10.0)
    # 0.2 - 3 x 0.1 rad; 0.1 m; 0.1 m; 2 x 0.2 rad; 2 x 0.2 - 0.5 x 0.1; 2 sin(0.15) rad, more than 0.05 m.
    expected = [1.0, 0.1, 0.1, 4.0, 0.35, 20.0 * math.sin(0.15), 0.0]
    assert violations == pytest.approx(expected, rel=1e-12, abs=1e-15)
    # Of a small machine a weld's place counts for more than its angle.
    assert constraint_violations(model, data, 0.1)[5] == pytest.approx(0.05)


def test_a_pose_is_closed_to_the_nearest_or_not_at_all() -> None:
    model = mujoco.MjModel.from_xml_string(four_bar())
    data = mujoco.MjData(model)
    data.qpos[:] += [0.02, -0.03, 0.01]
    before = data.qpos.copy()
    mujoco.mj_fwdPosition(model, data)
    assert constraint_violations(model, data, 1.0)[0] > 1e-3
    assert close_loops(model, data, 1e-12)
    mujoco.mj_fwdPosition(model, data)
    assert constraint_violations(model, data, 1.0)[0] <= 1e-12
    assert 1e-4 < np.abs(data.qpos - before).max() < 0.1
    # What is closed stays where it is.
    closed = data.qpos.copy()
    assert close_loops(model, data, 1e-12)
    assert data.qpos.tolist() == closed.tolist()
    # A rocker that is too short and too far is reached nowhere, and what is no number neither.
    short = mujoco.MjModel.from_xml_string(
        four_bar()
        .replace('name="C" pos="0.3 0 0"', 'name="C" pos="0.01 0 0"')
        .replace('pos="0.35 0 0"', 'pos="0.5 0 0"')
    )
    apart = mujoco.MjData(short)
    assert not close_loops(short, apart, 1e-12)
    data.qpos[0] = math.nan
    assert not close_loops(model, data, 1e-12)


CLOTH = (
    '<worldbody><body name="sheet" pos="0 0 1"><flexcomp name="cloth" type="grid" count="2 2 1" spacing="0.1 0.1 0.1" '
    'radius="0.01" dim="2" mass="0.1"><edge equality="true"/></flexcomp></body></worldbody>'
)


def test_flexes_are_refused_by_their_number() -> None:
    check_rigid(compiled())
    with pytest.raises(InvalidInput) as told:
        check_rigid(compiled(more=CLOTH))
    assert str(told.value) == "it has 1 flex: only rigid bodies have an exact motion here"


def test_an_equality_of_a_flex_is_of_no_kind() -> None:
    flexible = compiled(more=CLOTH)
    kinds = [equality_kind(flexible, index) for index in range(flexible.neq)]
    assert kinds.count("") == 1
    assert set(kinds) - {""} == {equality_kind(compiled(), index) for index in range(compiled().neq)}


# -- handles -----------------------------------------------------------------------------------------------------------


def test_equality_is_a_handle_when_either_end_is_mocap() -> None:
    model = compiled(
        BELT + '<weld name="grip" body1="hand" body2="held"/><connect name="pull" body1="held" body2="palm" '
        'anchor="0 0 0"/><connect name="pin" body1="crank" body2="slider" anchor="0 0 0"/>'
        '<weld name="off" body1="hand" body2="held" active="false"/>'
    )
    bodies = {name: model.body(name).id for name in ("world", "crank", "hand", "palm", "held")}
    assert {name: mocap_of(model, body) for name, body in bodies.items()} == {
        "world": None, "crank": None, "hand": bodies["hand"], "palm": bodies["hand"], "held": None,
    }  # fmt: skip
    assert [is_handle(model, k) for k in range(5)] == [False, True, True, False, True]
    assert handle_indices(model) == (1, 2)
    assert handle_words(model, (1, 2)) == (
        "grip is a handle: it drags held after the mocap body hand; "
        "pull is a handle: it drags held after the mocap body hand"
    )
    assert handle_words(model, ()) == ""


# -- what is asked of it -----------------------------------------------------------------------------------------------


def asked(drives: dict[str, str], seconds: float | None = None, keyframe: str | None = None) -> LoopRequest:
    return LoopRequest(drives, keyframe=keyframe, seconds=seconds)


def test_laws_are_of_driven_joints_and_loopless_joints_are_held() -> None:
    model = compiled('<connect body1="crank" body2="slider" anchor="0.5 0 0"/>', limited='limited="false"')
    laws, held = laws_of(model, read(model), asked({"slide": "move:0,0.3,2s"}))
    assert list(laws) == ["slide"]
    assert held == ("swivel", "float")
    assert laws["slide"].derivatives(np.array([0.0, 2.0]))[0] == pytest.approx([0.0, 0.3])
    assert duration(laws) == 2.0
    # A driven joint is not held, whether or not it is in a loop.
    alone = compiled()
    assert laws_of(alone, read(alone), asked({"slide": "move:0,0.3,2s"}))[1] == ("crank", "swivel", "float")


REFUSED: list[tuple[dict[str, str], str]] = [
    ({"cranc": "40rpm"}, "unknown joint 'cranc': did you mean 'crank'? choose from crank, slide"),
    ({"swivel": "40rpm"}, "--drive swivel: it is a ball joint; hinges and slides are driven: crank, slide"),
    ({}, "none of its joints is driven: give --drive JOINT=LAW for one of crank, slide; LAW: "),
    ({"slide": "hold"}, "none of its joints is driven: give --drive JOINT=LAW for one of crank, slide; LAW: "),
]


@pytest.mark.parametrize(("drives", "refusal"), REFUSED)
def test_a_drive_that_cannot_be_is_refused(drives: dict[str, str], refusal: str) -> None:
    model = compiled(BELT)
    with pytest.raises(InvalidInput) as told:
        laws_of(model, read(model), asked(drives))
    assert str(told.value).startswith(refusal)


KEYS = '<keyframe><key name="low" qpos="0 1 0 0 0 0 1 2 3 1 0 0 0"/><key qpos="0 1 0 0 0 0 1 2 3 1 0 0 0"/></keyframe>'


@pytest.mark.parametrize(("start", "more", "keyframe", "end"), [
    (0.0, "", None, ""),
    (0.0, KEYS, None, "; to start elsewhere, --keyframe takes low"),
    (0.0, KEYS, "low", ""),
    (0.5, "", None, ", which the pose that it starts from, at 0.5, is outside: "
     "begin inside it, by move:FROM,TO,TIME or a keyframe"),
    (0.5, KEYS, None, ", which the pose that it starts from, at 0.5, is outside; "
     "to start elsewhere, --keyframe takes low"),
])  # fmt: skip
def test_a_law_that_leaves_its_range_says_how_far_it_goes(
    start: float, more: str, keyframe: str | None, end: str
) -> None:
    model = compiled(BELT, more=more)
    pose = model.qpos0.copy()
    pose[model.joint("slide").qposadr[0]] = start
    with pytest.raises(InvalidInput) as told:
        laws_of(model, tree_of(model, pose), asked({"slide": "move:-0.2,0.3,1s"}, keyframe=keyframe))
    assert str(told.value) == (
        "--drive slide=move:-0.2,0.3,1s: it goes from -0.2 to 0.3, the joint's range is -0.1 to 0.4 m" + end
    )
    # Inside its range, and to its ends, it may go.
    for inside in ("move:-0.1,0.4,1s", "move:0,0.1,1s"):
        laws_of(model, tree_of(model, pose), asked({"slide": inside}))
    with pytest.raises(InvalidInput, match=r"goes from 0 to 0\.5,"):
        laws_of(model, tree_of(model, model.qpos0), asked({"slide": "move:0,0.5,1s"}))
    # It counts how far it goes in the time that is asked for.
    with pytest.raises(InvalidInput, match=r"goes from 0 to 5,"):
        laws_of(model, read(model), asked({"crank": "move:0,5,9s"}))


def mobility(undetermined: tuple[str, ...] = (), rigid: tuple[str, ...] = ()) -> Mobility:
    return Mobility(3, 3, 2, {}, undetermined, ("coupler",), 1.0, 0.0, rigid)


@pytest.mark.parametrize(("undetermined", "rigid", "points"), [
    ((), (), ("A", "B", "C")),
    (("B",), (), ("A", "C")),
    ((), ("A",), ("B", "C")),
    ((), ("A", "B", "C"), ("coupler", "crank", "rocker")),  # where no site is moved by closures: bodies
    ((), ("A", "B", "C", "crank", "coupler", "rocker"), ("A", "B", "C")),
])  # fmt: skip
def test_judged_sites_are_those_closures_move_and_drives_fix(
    undetermined: tuple[str, ...], rigid: tuple[str, ...], points: tuple[str, ...]
) -> None:
    model = mujoco.MjModel.from_xml_string(four_bar())
    found = judged_points(model, read(model), mobility(undetermined, rigid), asked({"crank": "40rpm"}))
    assert sorted(one.name for one in found) == sorted(points)
    kinds = {one.name: one.kind for one in found}
    assert kinds == {name: "site" if name.isupper() else "body" for name in points}


def test_named_point_is_refused_when_drives_do_not_determine_it() -> None:
    model, request = mujoco.MjModel.from_xml_string(four_bar()), LoopRequest({"crank": "40rpm"}, points=("rocker", "A"))
    found = judged_points(model, read(model), mobility(), request)
    assert [(one.name, one.kind, one.body) for one in found] == [("rocker", "body", 4), ("A", "site", 2)]
    with pytest.raises(InvalidInput, match="--point A: its drives do not determine it: coupler can still move"):
        judged_points(model, read(model), mobility(("A",)), request)
    with pytest.raises(InvalidInput, match="unknown point 'D'"):
        judged_points(model, read(model), mobility(), LoopRequest({"crank": "40rpm"}, points=("D",)))


def test_a_machine_is_one_of_conrods_or_a_file_in_its_own_pose(tmp_path: Any) -> None:
    assert "output" in {joint.name for joint in machine_tree("rssr").joints}
    file = tmp_path / "four_bar.xml"
    file.write_text(four_bar(keys=key("other", (0.1, 0.25, 0.3, 0.35), 2.0, -1.0)), encoding="utf-8")
    assert machine_tree(str(file)).start == pytest.approx(start_angles((0.1, 0.25, 0.3, 0.35), 1.0), abs=1e-15)
    assert math.isfinite(machine_tree(str(file)).extent)
