"""Spatial machines: closed forms by their lengths and by print, and the solver of any model's loops held against them.

Neither the closed form nor the solver knows of the other; the model is between them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import mujoco
import numpy as np
import pytest

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space.laws import law_of
from conrod.exact.space.mobility import mobility
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.mjcf.loops.reading import tree_of
from conrod.scenes.space import MACHINES, SpatialMachine

TIMES = np.linspace(0.0, 1.0, 60, endpoint=False) + 0.003
X, Y, Z = np.eye(3)
DEGREE = math.pi / 180.0
TO_ROUNDING = 1e-14  # [m]


def laws(machine: SpatialMachine, times: Array, order: int = 0) -> dict[str, Array]:
    """Coordinate of each driven joint, with derivatives by time: (order + 1, T)."""
    units = {joint: "m" if "mm" in law else "rad" for joint, law in machine.drives.items()}
    made = {joint: law_of(law, units[joint], 0.0, joint) for joint, law in machine.drives.items()}
    return {joint: law.derivatives(times)[: order + 1] for joint, law in made.items()}


# -- closed forms ------------------------------------------------------------------------------------------------------


def norm(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=-1)


def polar(radius: float, degrees: float) -> Array:
    return radius * np.array([math.cos(degrees * DEGREE), math.sin(degrees * DEGREE), 0.0])


def off(p: Mapping[str, Array], name: str, centre: Array, radius: float, normal: Array, height: float = 0.0):
    """How far a point is off a circle: off its distance from the centre, and off its height along the normal."""
    return [norm(p[name] - centre) - radius, (p[name] - centre) @ normal - height]


def cardan(p: Mapping[str, Array]) -> list[Array]:
    across = np.sum(p["input_arm"] * p["output_arm"], axis=-1)
    return [*off(p, "input_arm", 0 * X, 0.04, X), *off(p, "output_arm", 0 * X, 0.04, polar(1, 30)), across]


def double_cardan(p: Mapping[str, Array]) -> list[Array]:
    far = polar(0.3, 30)
    across = np.sum((p["middle_arm"] - far) * (p["output_arm"] - far), axis=-1)
    return [*off(p, "input_arm", 0 * X, 0.04, X), *off(p, "middle_arm", far, 0.04, polar(1, 30)),
            *off(p, "output_arm", far, 0.04, X), across]  # fmt: skip


def rssr(p: Mapping[str, Array]) -> list[Array]:
    return [*off(p, "crank_pin", 0 * X, 0.08, Z), *off(p, "rocker_pin", np.array([0.3, 0.15, 0.05]), 0.25, X),
            norm(p["rocker_pin"] - p["crank_pin"]) - 0.42]  # fmt: skip


def bennett(p: Mapping[str, Array]) -> list[Array]:
    twist, other_twist, crank = 40 * DEGREE, 75 * DEGREE, p["crank_pin"]
    other = 0.2 * math.sin(other_twist) / math.sin(twist)
    out = np.array([0.0, math.sin(other_twist), math.cos(other_twist)])
    # Across the rod at the crank pin: the crank's second axis, which is at the twist from the first.
    axis = math.cos(twist) * Z + math.sin(twist) * np.cross(crank / 0.2, Z)
    rod = p["rocker_pin"] - crank
    return [*off(p, "crank_pin", 0 * X, 0.2, Z), *off(p, "rocker_pin", -other * X, 0.2, out),
            norm(rod) - other, np.sum(axis * rod, axis=-1)]  # fmt: skip


def delta(p: Mapping[str, Array]) -> list[Array]:
    found = []
    for k, angle in enumerate((-90, 30, 150), 1):
        elbow, radial = p[f"elbow_{k}"], polar(1, angle)
        wrist = p["platform"] + 0.044 * radial
        found += [*off(p, f"elbow_{k}", 0.164 * radial, 0.524, np.cross(Z, radial)), norm(wrist - elbow) - 1.244]
    return found


def stewart(p: Mapping[str, Array]) -> list[Array]:
    # The platform is rigid: inner products of what is fixed in it are those of the reference pose.
    arms = [polar(0.3, middle + side) for middle in (-90, 30, 150) for side in (-50, 50)]
    fixed = np.array([0.1 * (X + Z), *arms])
    moved = np.stack([p[name] - p["platform"] for name in ("tool", *(f"leg_{k}_end" for k in range(1, 7)))], axis=1)
    return [moved @ np.swapaxes(moved, 1, 2) - fixed @ fixed.T]


def slider_crank(p: Mapping[str, Array]) -> list[Array]:
    # Rodrigues' matrix of 50 degrees about (1, 2, -1).
    k = np.array([1.0, 2.0, -1.0]) / math.sqrt(6.0)
    skew = np.array([[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]])
    frame = np.eye(3) + math.sin(50 * DEGREE) * skew + (1.0 - math.cos(50 * DEGREE)) * skew @ skew
    shaft = np.array([0.1, -0.1, 0.2])
    slider = p["slider"] - shaft
    return [*off(p, "crank_pin", shaft, 0.1, frame[:, 2]), norm(p["slider"] - p["crank_pin"]) - 0.3,
            slider @ frame[:, 1] - 0.02, slider @ frame[:, 2]]  # fmt: skip


# Its loops; the freedoms of its model, idle spins of rods included; and a parameter that is a little different.
KNOWN = {
    "cardan": (cardan, 1, {"bend": 30.1}),
    "double-cardan": (double_cardan, 1, {"phasing": 0.1}),
    "double-cardan-misphased": (double_cardan, 1, {"bend": 30.1}),
    "rssr": (rssr, 1, {"rod": 0.42 * 1.001}),
    "rssr-idle-spin": (rssr, 2, {"rod": 0.42 * 1.001}),
    "bennett": (bennett, 1, {"other_twist": 75.1}),
    "delta": (delta, 3, {"rod": 1.244 * 1.001}),
    "stewart": (stewart, 6, {"platform": 0.3 * 1.001}),
    "tilted-slider-crank": (slider_crank, 1, {"rod": 0.3 * 1.001}),
}
ANGLES = ("bend", "phasing", "other_twist")


@pytest.mark.parametrize("name", MACHINES)
def test_the_closed_form_keeps_its_loops_closed(name: str) -> None:
    machine, loops = MACHINES[name](), KNOWN[name][0]
    points = {point: values[0] for point, values in machine.points(laws(machine, TIMES)).items()}
    assert max(np.abs(opening).max() for opening in loops(points)) < TO_ROUNDING
    # Negative control: one observed point a tenth of a millimetre off opens a loop.
    moved = next(iter(points))
    points[moved] = points[moved] + 1e-4 * np.array([1.0, 2.0, 3.0]) / math.sqrt(14.0)
    assert max(np.abs(opening).max() for opening in loops(points)) > 1e-7


@pytest.mark.parametrize(("name", "power"), [("cardan", 1), ("double-cardan", 0), ("double-cardan-misphased", 2)])
def test_the_output_shaft_fluctuates_as_its_phasing_says(name: str, power: int) -> None:
    # Uicker, Pennock, Shigley: between cos and 1 / cos of the angle; two joints out of phase multiply, in phase cancel.
    machine, quarter_turns = MACHINES[name](), np.arange(8) * 0.125
    arm = machine.points(laws(machine, quarter_turns, 1))["output_arm"]
    ratio = norm(arm[1]) / 0.04 / (2.0 * math.pi)
    bend = math.cos(30 * DEGREE) ** power
    assert (ratio.min(), ratio.max()) == pytest.approx((bend, 1.0 / bend), abs=1e-13)


@pytest.mark.parametrize(
    ("angles", "place"), [((0.0, 0.0, 0.0), (0.0, 0.0, -1.065)), ((10.0, 20.0, 30.0), (0.108, -0.180, -1.244))]
)
def test_the_delta_stands_where_williams_says(angles: tuple[float, ...], place: tuple[float, ...]) -> None:
    # Williams (2016), The Delta Parallel Robot: Kinematics Solutions, forward position examples, ABB FlexPicker. Its
    # dimensions are printed to a millimetre, and so are its results.
    drives = {f"input_{k}": np.array([[angle * DEGREE]]) for k, angle in enumerate(angles, 1)}
    assert MACHINES["delta"]().points(drives)["platform"][0, 0] == pytest.approx(place, abs=1e-3)


@pytest.mark.parametrize(("name", "size"), [("rssr", {"rod": 1.0}), ("delta", {"rod": 0.3})])
def test_a_machine_whose_links_do_not_reach_is_refused(name: str, size: dict[str, float]) -> None:
    with pytest.raises(InvalidInput, match="cannot be assembled in the reference pose"):
        MACHINES[name](**size)


# -- the solver --------------------------------------------------------------------------------------------------------

# From one pose to another a fifth of a period on, where no law has a rate or an acceleration of 0.
DURATION = 0.2
SAMPLES = np.linspace(0.0, DURATION, 7)
# Of travel, per period^k: of position, velocity, acceleration and jerk.
BARS = (1e-12, 1e-12, 1e-12, 1e-9)
Solved = tuple[DrivenTree, SpatialMotion]


def solved(machine: SpatialMachine, defect: Callable[[mujoco.MjModel], None] | None = None) -> Solved:
    model = mujoco.MjModel.from_xml_string(machine.mjcf)
    if defect:
        defect(model)
    tree = tree_of(model, model.qpos0)
    units = {joint.name: joint.unit for joint in tree.joints}
    made = DrivenTree(tree, {joint: law_of(law, units[joint], 0.0, joint) for joint, law in machine.drives.items()})
    made.go(made.closed(tree.start[:, None], 0.0)[0], DURATION)
    return made, made.motion(SAMPLES)


def errors(machine: SpatialMachine, motion: SpatialMotion) -> Array:
    """Largest of all points, of travel by period^k, (4,)."""
    found = np.zeros(4)
    for name, exact in machine.points(laws(machine, SAMPLES, 3)).items():
        point = motion.points[name]
        travel = max(np.ptp(exact[0], axis=0).max(), 1e-3)
        for k, values in enumerate((point.position, point.velocity, point.acceleration, point.jerk)):
            found[k] = max(found[k], np.abs(values - exact[k]).max() / travel / (2.0 * math.pi) ** k)
    return found


@pytest.mark.parametrize("name", MACHINES)
def test_the_solver_moves_a_model_as_its_closed_form_says(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conrod.exact.space.motion.POSES", 12)  # a fifth of a period needs no more
    machine, (_, freedoms, change) = MACHINES[name](), KNOWN[name]
    tree, motion = solved(machine)
    assert (errors(machine, motion) < BARS).all()
    counted = mobility(tree)
    assert counted.left == freedoms
    assert bool(counted.idle) == (name == "rssr-idle-spin")
    # Negative control: a link 0.1 % longer, or an angle 0.1 degrees larger, is another machine.
    other = {key: math.radians(value) if key in ANGLES else value for key, value in change.items()}
    assert errors(MACHINES[name](**other), motion)[0] > 1e-5


def longer_link(model: mujoco.MjModel) -> None:
    """0.1 % more between a link and the next; where all links meet in a point, to the closure's pin."""
    offsets = [model.body_pos[body] for body, parent in enumerate(model.body_parentid) if parent]
    far = [offset for offset in offsets if offset.any()]
    (far[0] if far else model.site_pos[model.eq_obj1id[0]])[:] *= 1.001


def turned_axis(model: mujoco.MjModel) -> None:
    """The first joint's axis 0.1 degrees off."""
    model.jnt_axis[0] += math.tan(0.1 * DEGREE) * np.cross(model.jnt_axis[0], [0.36, 0.48, 0.8])


def shifted_closure(model: mujoco.MjModel) -> None:
    """The first closure is anchored 0.1 mm off."""
    weld = model.eq_type[0] == mujoco.mjtEq.mjEQ_WELD
    (model.eq_data[0, 3:6] if weld else model.site_pos[model.eq_obj1id[0]])[:] += [6e-5, 0.0, 8e-5]


# A shaft may stand anywhere along its axis, and legs follow a platform that is driven, whatever they are.
UNSEEN = [(longer_link, name) for name in ("cardan", "double-cardan", "double-cardan-misphased")]
DEFECTS = [(defect, name) for defect in (longer_link, turned_axis, shifted_closure) for name in MACHINES]


@pytest.mark.slow
@pytest.mark.parametrize(("defect", "name"), [case for case in DEFECTS if case not in UNSEEN and case[1] != "stewart"])
def test_a_model_built_a_little_wrong_moves_otherwise(defect: Callable[[mujoco.MjModel], None], name: str) -> None:
    machine = MACHINES[name]()
    assert errors(machine, solved(machine, defect)[1])[0] > 1e-6
