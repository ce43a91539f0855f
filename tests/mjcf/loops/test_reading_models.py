"""A model read from MuJoCo stands and moves as MuJoCo's own kinematics do, in any pose of any tree."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from conrod.engines.mujoco.model import constraint_jacobian
from conrod.exact.motion import Array
from conrod.exact.space import SpatialTree
from conrod.exact.space.forward_kinematics import forward_kinematics
from conrod.exact.space.loop_closure import jacobian, residuals
from conrod.exact.space.motion import displace
from conrod.mjcf.driving import site_points
from conrod.mjcf.reading import tree_of

# Joints of a body as MuJoCo allows them: a ball comes after hinges, and no body has more than six freedoms.
JOINTS = (
    ("hinge",), ("slide",), ("ball",), (), ("hinge", "hinge"), ("slide", "hinge"), ("hinge", "slide", "hinge"),
    ("hinge", "ball"), ("ball", "slide"), ("slide", "slide", "slide", "hinge", "hinge", "hinge"),
)  # fmt: skip


def random_tree(seed: int, bodies: int = 7, equality: str = "", tendon: str = "") -> mujoco.MjModel:
    """A tree with a floating body, a mocap body and sites S1, S2, ... on its bodies B1, B2, ..."""
    draw = np.random.default_rng(seed)
    text = f'<body name="hand" mocap="true" {_frame(draw)}><site name="S0" {_frame(draw)}/></body>'
    text += f'<body name="float" {_frame(draw)}><freejoint name="float"/>{_mass(draw)}<site name="SF" {_frame(draw)}/>'
    text += f'<body name="F1" {_frame(draw)}><joint name="F1" {_joint(draw, "hinge")}/>{_mass(draw)}</body></body>'
    open_bodies = 0
    for number in range(1, bodies + 1):
        kinds = JOINTS[draw.integers(len(JOINTS))]
        text += f'<body name="B{number}" {_frame(draw)}>{_mass(draw)}<site name="S{number}" {_frame(draw)}/>'
        text += "".join(f'<joint name="B{number}{k}" {_joint(draw, kind)}/>' for k, kind in enumerate(kinds))
        open_bodies += 1
        while open_bodies and draw.random() < 0.4:
            text, open_bodies = text + "</body>", open_bodies - 1
    text += "</body>" * open_bodies
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><option gravity="{_text(draw.normal(size=3))}"/>'
        f"<worldbody>{text}</worldbody><tendon>{tendon}</tendon><equality>{equality}</equality></mujoco>"
    )


def _text(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def _frame(draw: np.random.Generator) -> str:
    return f'pos="{_text(0.3 * draw.normal(size=3))}" quat="{_text(draw.normal(size=4))}"'


def _mass(draw: np.random.Generator) -> str:
    size = draw.uniform(0.1, 2.0)
    inertia = size * np.array([0.01, 0.012, 0.02]) * draw.uniform(0.9, 1.1)
    return f'<inertial {_frame(draw)} mass="{size}" diaginertia="{_text(inertia)}"/>'


def _joint(draw: np.random.Generator, kind: str) -> str:
    place, axis = f'pos="{_text(0.2 * draw.normal(size=3))}"', f'axis="{_text(draw.normal(size=3))}"'
    made = f'type="{kind}" {place}' + (f' {axis} ref="{draw.normal()}"' if kind in ("hinge", "slide") else "")
    own = f'armature="{draw.uniform(0, 0.1)}" damping="{draw.uniform(0, 0.5)}"'
    spring = f' stiffness="{draw.uniform(0, 5)}" springref="{draw.normal()}"' if kind in ("hinge", "slide") else ""
    return f"{made} {own}{spring}"


SEEDS = range(6)
ROUNDING = 1e-14  # of bodies up to a few metres away


def read(model: mujoco.MjModel) -> SpatialTree:
    return tree_of(model, model.qpos0)


def at(model: mujoco.MjModel, seed: int) -> tuple[mujoco.MjData, Array]:
    """Data with all that belongs to a random state, and its coordinates (nq, 1)."""
    draw, data = np.random.default_rng(seed), mujoco.MjData(model)
    data.qpos[:] = draw.normal(size=model.nq)
    mujoco.mj_normalizeQuat(model, data.qpos)
    data.qvel[:] = draw.normal(size=model.nv)
    mujoco.mj_forward(model, data)
    data.qacc[:] = draw.normal(size=model.nv)
    mujoco.mj_rnePostConstraint(model, data)
    return data, data.qpos[:, None].copy()


@pytest.mark.parametrize("seed", SEEDS)
def test_all_bodies_and_points_stand_where_mujoco_has_them(seed: int) -> None:
    model = random_tree(seed)
    data, coordinates = at(model, seed)
    tree = read(model)
    found = forward_kinematics(tree, coordinates)
    size = np.abs(data.xpos).max()
    for body in range(model.nbody):
        assert found.places[body][0][:, 0] == pytest.approx(data.xpos[body], abs=ROUNDING * size)
        assert found.turns[body][0][..., 0].ravel() == pytest.approx(data.xmat[body], abs=ROUNDING)
    for seen in site_points(model, tuple(tree.points)):
        place = found.point(tree.points[seen.name])[0][:, 0]
        assert place == pytest.approx(seen.motion(model, data)[0], abs=ROUNDING * size)
    assert set(tree.points) >= {"SF"}
    assert "S0" not in tree.points  # on a body that stands still


def test_a_joint_in_another_place_is_seen() -> None:
    # Negative control: what a pose depends on makes a difference, each of it.
    model = random_tree(0)
    _, coordinates = at(model, 0)
    before = forward_kinematics(read(model), coordinates)
    for field in ("jnt_pos", "jnt_axis", "body_pos", "body_quat", "qpos0"):
        edited = random_tree(0)
        getattr(edited, field)[-1] += 1e-6
        after = forward_kinematics(read(edited), coordinates)
        assert max(np.abs(a[0] - b[0]).max() for a, b in zip(before.places, after.places, strict=True)) > 1e-9, field


@pytest.mark.parametrize("seed", SEEDS)
def test_points_move_and_accelerate_as_mujocos_do(seed: int) -> None:
    model = random_tree(seed)
    data, coordinates = at(model, seed)
    tree = read(model)
    found = forward_kinematics(tree, coordinates, np.stack([data.qvel, data.qacc])[:, :, None])
    for point in site_points(model, tuple(tree.points)):
        _, velocity, acceleration = point.motion(model, data)
        series = found.point(tree.points[point.name])
        size = 1.0 + np.abs(acceleration).max()
        assert series[1][:, 0] == pytest.approx(velocity, abs=1e-13 * size)
        assert 2.0 * series[2][:, 0] == pytest.approx(acceleration, abs=1e-12 * size)


# -- closures ----------------------------------------------------------------------------------------------------------

CONNECTS = (
    '<connect name="c" body1="B3" anchor="0.1 -0.2 0.3"/>',
    '<connect name="c" body1="hand" body2="B5" anchor="0.1 -0.2 0.3"/>',
    '<connect name="c" site1="S0" site2="S6"/>',
    '<connect name="c" body1="float" body2="B4" anchor="0.1 0 0"/>',
)
COUPLINGS = (
    '<joint name="c" joint1="F1" joint2="{hinge}" polycoef="0.1 0.2 -0.3 0.4 0.5"/>',
    '<tendon name="c" tendon1="T1" polycoef="0.1 0.2 -0.3 0.4 0.5"/>',
    '<tendon name="c" tendon1="T1" tendon2="T2" polycoef="0.1 0.2 -0.3 0.4 0.5"/>',
)
WELDS = (
    '<weld name="c" body1="B2" body2="B5" anchor="0.1 0.2 0.3" relpose="0.2 0.1 0.3 0.4 -0.5 0.6 0.2"/>',
    '<weld name="c" body1="hand" body2="B5" torquescale="0.3"/>',
    '<weld name="c" body1="B6" anchor="0.1 0.2 0.3"/>',
    '<weld name="c" site1="S3" site2="S6"/>',
)


def closed_by(closure: str, seed: int) -> mujoco.MjModel:
    model = random_tree(seed)
    # Hinges and slides.
    names = [model.joint(j).name for j in range(model.njnt) if model.jnt_type[j] >= 2 and model.joint(j).name != "F1"]
    tendons = (
        f'<fixed name="T1"><joint joint="F1" coef="0.7"/><joint joint="{names[0]}" coef="-1.3"/></fixed>'
        f'<fixed name="T2"><joint joint="{names[-1]}" coef="0.4"/></fixed>'
    )
    return random_tree(seed, equality=closure.format(hinge=names[0]), tendon=tendons)


@pytest.mark.parametrize("closure", CONNECTS + COUPLINGS)
@pytest.mark.parametrize("seed", SEEDS[:3])
def test_connect_and_coupling_have_mujocos_residual_and_jacobian(closure: str, seed: int) -> None:
    model = closed_by(closure, seed)
    data, coordinates = at(model, seed)
    tree = read(model)
    found = forward_kinematics(tree, coordinates)
    # A coupling whose dependent sum is of angles is weighed by the extent.
    joints = {joint.rate: joint for joint in tree.joints}
    sums = tree.closures[0].sums
    angles = bool(sums) and not any(joints[rate].unit == "m" for rate in sums[0])
    weight, size = tree.extent if angles else 1.0, 1.0 + np.abs(data.efc_pos).max()
    assert residuals(found, 0)[0, :, 0] == pytest.approx(weight * data.efc_pos, abs=1e-14 * size)
    assert jacobian(found, 1)[0] == pytest.approx(weight * constraint_jacobian(model, data), abs=1e-13 * size)


def differences(tree: SpatialTree, coordinates: Array) -> Array:
    """Derivatives of what closures leave open by the joint rates (rows, nv), as differences."""
    columns, step = [], 1e-5
    for rate in range(tree.freedom):
        way = np.zeros((tree.freedom, 1))
        way[rate] = step
        ends = [
            residuals(forward_kinematics(tree, displace(tree, coordinates, sign * way)), 0)[0, :, 0]
            for sign in (1.0, -1.0)
        ]
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.array(columns).T


def welded_at(model: mujoco.MjModel, seed: int) -> tuple[mujoco.MjModel, mujoco.MjData, Array]:
    """The model with its weld, of bodies or of sites, made to be closed at a random pose."""
    data, coordinates = at(model, seed)
    one, two = int(model.eq_obj1id[0]), int(model.eq_obj2id[0])
    if model.eq_objtype[0] == mujoco.mjtObj.mjOBJ_SITE:
        bodies = [int(model.site_bodyid[site]) for site in (one, two)]
        turns = [data.xmat[body].reshape(3, 3) for body in bodies]
        place = data.site_xpos[one]
        model.site_pos[two] = turns[1].T @ (place - data.xpos[bodies[1]])
        mujoco.mju_mat2Quat(model.site_quat[two], (turns[1].T @ data.site_xmat[one].reshape(3, 3)).ravel())
    else:
        turns = [data.xmat[body].reshape(3, 3) for body in (one, two)]
        anchor = data.xpos[two] + turns[1] @ model.eq_data[0, :3]
        model.eq_data[0, 3:6] = turns[0].T @ (anchor - data.xpos[one])
        mujoco.mju_mat2Quat(model.eq_data[0, 6:10], (turns[0].T @ turns[1]).ravel())
    mujoco.mj_forward(model, data)
    return model, data, coordinates


@pytest.mark.parametrize("closure", WELDS)
@pytest.mark.parametrize("seed", SEEDS[:3])
def test_weld_closes_as_in_mujoco_and_opens_by_its_jacobian(closure: str, seed: int) -> None:
    model, data, coordinates = welded_at(random_tree(seed, equality=closure), seed)
    tree = read(model)
    assert np.abs(data.efc_pos).max() < 1e-14 * 10.0
    assert np.abs(residuals(forward_kinematics(tree, coordinates), 0)).max() < 1e-13
    mine = jacobian(forward_kinematics(tree, coordinates), 1)[0]
    assert mine == pytest.approx(differences(tree, coordinates), abs=1e-7)
    assert mine[:3] == pytest.approx(constraint_jacobian(model, data)[:3], abs=1e-13)
