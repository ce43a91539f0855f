"""Closed forms of spatial machines satisfy their own loops: rods keep their lengths, hinges their angles."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pytest
from spatial_poses import driven

from conrod.exact.motion import Array
from conrod.scenes.space import MACHINES

TIMES = np.linspace(0.0, 1.0, 60, endpoint=False) + 0.003
X, Y, Z = np.eye(3)
DEGREE = math.pi / 180.0
TO_ROUNDING = 1e-14  # [m], or of a unit vector


def norm(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=-1)


def unit(vectors: Array) -> Array:
    return vectors / norm(vectors)[..., None]


def cardan(p: Mapping[str, Array]) -> list[Array]:
    out = np.array([math.cos(30 * DEGREE), math.sin(30 * DEGREE), 0.0])
    driving, driven_arm = p["input_arm"] / 0.04, p["output_arm"] / 0.04
    across = np.sum(driving * driven_arm, axis=-1)
    return [norm(driving) - 1.0, norm(driven_arm) - 1.0, driving @ X, driven_arm @ out, across]


def double_cardan(p: Mapping[str, Array]) -> list[Array]:
    middle = np.array([math.cos(30 * DEGREE), math.sin(30 * DEGREE), 0.0])
    first, third, fourth = (p[name] / 0.04 for name in ("input_arm", "middle_arm", "output_arm"))
    third, fourth = third - 7.5 * middle, fourth - 7.5 * middle
    return [norm(arm) - 1.0 for arm in (first, third, fourth)] + [
        first @ X, third @ middle, fourth @ X, np.sum(third * fourth, axis=-1)
    ]  # fmt: skip


def right_phasing(p: Mapping[str, Array]) -> list[Array]:
    # Forks of the intermediate shaft in line: its second fork is across the first cross's other arm.
    middle = np.array([math.cos(30 * DEGREE), math.sin(30 * DEGREE), 0.0])
    return [*double_cardan(p), np.sum((p["middle_arm"] / 0.04 - 7.5 * middle) * p["input_arm"] / 0.04, axis=-1)]


def spherical(p: Mapping[str, Array]) -> list[Array]:
    out = np.array([math.sin(80 * DEGREE), 0.0, math.cos(80 * DEGREE)])
    crank, rocker = p["crank_pin"] / 0.2, p["rocker_pin"] / 0.2
    return [norm(crank) - 1.0, crank @ Z - math.cos(30 * DEGREE), norm(rocker) - 1.0,
            rocker @ out - math.cos(70 * DEGREE), np.sum(crank * rocker, axis=-1) - math.cos(60 * DEGREE)]  # fmt: skip


def rssr(p: Mapping[str, Array]) -> list[Array]:
    crank, rocker = p["crank_pin"], p["rocker_pin"] - [0.3, 0.15, 0.05]
    return [norm(crank) - 0.08, crank @ Z, norm(rocker) - 0.25, rocker @ X, norm(p["rocker_pin"] - crank) - 0.42]


def bennett(p: Mapping[str, Array]) -> list[Array]:
    # Hinge axes carried round the loop, link by link, come back to the one on the ground.
    twist, other_twist = 40 * DEGREE, 75 * DEGREE
    other = 0.2 * math.sin(other_twist) / math.sin(twist)
    pivot = np.array([-other, 0.0, 0.0])
    links = [
        p["crank_pin"],
        p["rocker_pin"] - p["crank_pin"],
        pivot - p["rocker_pin"],
        np.broadcast_to(-pivot, (60, 3)),
    ]
    axis, closures = np.broadcast_to(Z, (60, 3)), []
    for link, length, angle in zip(links, (0.2, other, 0.2, other), (twist, other_twist) * 2, strict=True):
        closures += [norm(link) - length, np.sum(axis * link, axis=-1)]
        axis = math.cos(angle) * axis + math.sin(angle) * np.cross(unit(link), axis)
    return [*closures, axis - Z]


def sarrus(p: Mapping[str, Array]) -> list[Array]:
    foot, other_foot, plate = 0.1 * X, 0.1 * Y, p["plate"]
    return [norm(p["knee"] - foot) - 0.15, norm(plate + foot - p["knee"]) - 0.2, p["knee"] @ Y,
            norm(p["other_knee"] - other_foot) - 0.18, norm(plate + other_foot - p["other_knee"]) - 0.16,
            p["other_knee"] @ X, plate[:, :2]]  # fmt: skip


def delta(p: Mapping[str, Array]) -> list[Array]:
    found = []
    for k, angle in enumerate((-90, 30, 150), 1):
        radial = np.array([math.cos(angle * DEGREE), math.sin(angle * DEGREE), 0.0])
        elbow, wrist = p[f"elbow_{k}"], p["platform"] + 0.044 * radial
        found += [norm(elbow - 0.164 * radial) - 0.524, norm(wrist - elbow) - 1.244, elbow @ np.cross(Z, radial)]
    return found


def stewart(p: Mapping[str, Array]) -> list[Array]:
    # The platform is rigid: inner products of what is fixed in it are those of the reference pose.
    fixed = np.array([[0.1, 0.0, 0.1], *stewart_arms()])
    moved = np.stack([p[name] - p["platform"] for name in ("tool", *(f"leg_{k}_end" for k in range(1, 7)))], axis=1)
    return [moved @ np.swapaxes(moved, 1, 2) - fixed @ fixed.T]


def stewart_arms() -> list[Array]:
    angles = [middle + side for middle in (-90, 30, 150) for side in (-50, 50)]
    return [0.3 * np.array([math.cos(a * DEGREE), math.sin(a * DEGREE), 0.0]) for a in angles]


def slider_crank(p: Mapping[str, Array]) -> list[Array]:
    # Rodrigues' matrix of 50 degrees about (1, 2, -1).
    k = np.array([1.0, 2.0, -1.0]) / math.sqrt(6.0)
    skew = np.array([[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]])
    frame = np.eye(3) + math.sin(50 * DEGREE) * skew + (1.0 - math.cos(50 * DEGREE)) * skew @ skew
    crank, slider = (p[name] - [0.1, -0.1, 0.2] for name in ("crank_pin", "slider"))
    return [norm(crank) - 0.1, crank @ frame[:, 2], norm(slider - crank) - 0.3, slider @ frame[:, 1] - 0.02,
            slider @ frame[:, 2]]  # fmt: skip


LOOPS = {
    "cardan": cardan, "double-cardan": right_phasing, "double-cardan-misphased": double_cardan,
    "spherical-four-bar": spherical, "rssr": rssr, "rssr-idle-spin": rssr, "bennett": bennett, "sarrus": sarrus,
    "delta": delta, "stewart": stewart, "tilted-slider-crank": slider_crank,
}  # fmt: skip


@pytest.mark.parametrize("name", MACHINES)
def test_the_closed_form_keeps_its_loops_closed(name: str) -> None:
    machine = MACHINES[name]()
    points = {point: values[0] for point, values in machine.points(driven(machine, TIMES)).items()}
    openings = LOOPS[name](points)
    assert max(np.abs(opening).max() for opening in openings) < TO_ROUNDING
    # Negative control: one observed point a tenth of a millimetre off opens a loop.
    moved = next(iter(points))
    points[moved] = points[moved] + 1e-4 * unit(np.array([1.0, 2.0, 3.0]))
    assert max(np.abs(opening).max() for opening in LOOPS[name](points)) > 1e-6


def test_legs_of_the_stewart_platform_are_as_long_as_their_slides_say() -> None:
    machine = MACHINES["stewart"]()
    drives = driven(machine, TIMES)
    points, joints = machine.points(drives), machine.joints(drives)
    feet = [middle + side for middle in (-90, 30, 150) for side in (-10, 10)]
    for k, (foot, arm) in enumerate(zip(feet, stewart_arms(), strict=True), 1):
        base = 0.5 * np.array([math.cos(foot * DEGREE), math.sin(foot * DEGREE), 0.0])
        start = norm(arm + 0.6 * Z - base)
        assert norm(points[f"leg_{k}_end"][0] - base) - start == pytest.approx(joints[f"leg_{k}"][0], abs=TO_ROUNDING)


# -- published values --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "power"), [("cardan", 1), ("double-cardan", 0), ("double-cardan-misphased", 2)])
def test_the_output_shaft_fluctuates_as_its_phasing_says(name: str, power: int) -> None:
    # Uicker, Pennock, Shigley: between cos and 1 / cos of the angle; two joints out of phase multiply, in phase cancel.
    machine, quarter_turns = MACHINES[name](), np.arange(8) * 0.125
    ratio = machine.joints(driven(machine, quarter_turns, 1))["output"][1] / (2.0 * math.pi)
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


def test_bennetts_angles_keep_their_product() -> None:
    machine = MACHINES["bennett"]()
    drives = driven(machine, TIMES)
    turn = drives["input"][0] + 60 * DEGREE
    points = machine.points(drives)
    crank, coupler = unit(points["crank_pin"][0]), unit(points["rocker_pin"][0] - points["crank_pin"][0])
    crank_axis = math.cos(40 * DEGREE) * Z + math.sin(40 * DEGREE) * np.cross(crank, Z)
    coupler_turn = np.arctan2(np.sum(np.cross(crank, coupler) * crank_axis, axis=-1), np.sum(crank * coupler, axis=-1))
    product = math.sin(57.5 * DEGREE) / math.sin(17.5 * DEGREE)
    assert np.tan(0.5 * turn) * np.tan(0.5 * coupler_turn) == pytest.approx(product, rel=1e-11)


# Links with the ground, and the freedoms of every joint: Gruebler's count of each.
MECHANISMS = {
    "cardan": (4, [1] * 4), "double-cardan": (6, [1] * 6), "double-cardan-misphased": (6, [1] * 6),
    "spherical-four-bar": (4, [1] * 4), "rssr": (4, [1, 2, 3, 1]), "rssr-idle-spin": (4, [1, 3, 3, 1]),
    "bennett": (4, [1] * 4), "sarrus": (6, [1] * 6), "delta": (14, [1] * 12 + [3] * 6),
    "stewart": (14, [2, 1, 3] * 6), "tilted-slider-crank": (4, [1] * 4),
}  # fmt: skip


@pytest.mark.parametrize("name", MACHINES)
def test_grueblers_count_is_of_the_mechanism(name: str) -> None:
    links, freedoms = MECHANISMS[name]
    assert MACHINES[name]().gruebler == 6 * (links - 1) - sum(6 - f for f in freedoms)
