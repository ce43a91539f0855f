"""Mechanisms of many loops: read, solved, translated and run.

With lower pairs alone, n links of mobility 3 (n - 1) - 2 j = 1 have j = (3 n - 4) / 2 joints and L = j - n + 1 =
n / 2 - 1 independent loops; each higher pair adds half a loop. So 50 links of mobility 1 have 24 loops or more, and
20 loops are those of 42 links: both are taken.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from conrod.comparison.compare import compare
from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_named
from conrod.engines.run import run_in_one_piece
from conrod.engines.spanning_tree import machine_tree
from conrod.exact.configuration_curve import ConfigurationCurve
from conrod.exact.elimination import triangular_blocks
from conrod.exact.joint_equations import joint_residual, pose_jets
from conrod.execution.resolve_arguments import select_scene
from conrod.scenes.described_scene import DescribedScene, scene_from_tables

Point = tuple[float, float]


class LargeMechanism:
    """A loop is added as one of three pairs of links: coupler and rocker, two bars between them, or rod and slider."""

    def __init__(self, loops: int) -> None:
        self.ground: dict[str, Point] = {"O": (0.0, 0.0)}
        self.bodies: dict[str, Any] = {}
        self.joints: dict[str, Any] = {}
        self._rocker = 0
        tip = (0.1 * math.cos(1.0), 0.1 * math.sin(1.0))
        self._bar("crank", 1.0, O=self.ground["O"], P=tip)
        self._pin("shaft", "ground.O", "crank.O")
        self._end, self._at = "crank.P", tip
        for k in range(1, loops + 1):
            (self._slider, self._next_rocker, self._bars)[k % 3](k)

    def tables(self) -> dict[str, Any]:
        """What stands in the file, drawn at crank angle 0."""
        return {
            "name": "large-linkage",
            "title": "Linkage of many loops",
            "source": "a generator of tests",
            "drawn": True,
            "output": "P",
            "gravity": [0.0, -9.81],
            "driver": {"joint": "shaft", "speed": 6.0},
            "ground": {"points": self.ground},
            "bodies": self.bodies,
            "joints": self.joints,
            "observed": {"P": f"rocker{self._rocker}.P", "A": "coupler1.R"},
        }

    def _next_rocker(self, k: int) -> None:
        x, y = 0.25 + k / 6.0, -0.2 - 0.02 * math.sin(1.3 * k)
        length, turn = 0.3 * (1.0 + 0.04 * math.sin(2.1 * k)), math.radians(90.0 + 4.0 * math.sin(1.7 * k))
        top = (x + length * math.cos(turn), y + length * math.sin(turn))
        above = (0.5 * (self._at[0] + top[0]), 0.5 * (self._at[1] + top[1]) + 0.1)
        within = (x + 0.6 * (top[0] - x), y + 0.6 * (top[1] - y))
        self.ground[f"O{k}"] = (x, y)
        self._bar(f"coupler{k}", 0.8, L=self._at, R=top, C=above)
        self._bar(f"rocker{k}", 1.2, O=(x, y), P=top, M=within)
        self._pin(f"left{k}", self._end, f"coupler{k}.L")
        self._pin(f"right{k}", f"coupler{k}.R", f"rocker{k}.P")
        self._pin(f"pivot{k}", f"ground.O{k}", f"rocker{k}.O")
        self._end, self._at, self._rocker = f"rocker{k}.P", top, k
        self._carriers = (above, within)

    def _bars(self, k: int) -> None:
        above, within = self._carriers
        top = (within[0] + 0.2, within[1] + 0.1)
        self._bar(f"strut{k}", 0.5, A=above, T=top)
        self._bar(f"link{k}", 0.5, B=within, T=top)
        self._pin(f"strut-pin{k}", f"coupler{k - 1}.C", f"strut{k}.A")
        self._pin(f"link-pin{k}", f"rocker{k - 1}.M", f"link{k}.B")
        self._pin(f"tie{k}", f"strut{k}.T", f"link{k}.T")
        self._carried = top

    def _slider(self, k: int) -> None:
        place = (self._carried[0] + 0.1, self._carried[1] - 0.45)
        self.ground[f"S{k}"] = place
        self._bar(f"rod{k}", 0.6, A=self._carried, S=place)
        self.bodies[f"slider{k}"] = {"points": {"S": place}, "mass": 0.7, "inertia": 1e-3, "centre_of_gravity": place}
        self._pin(f"rod-pin{k}", f"link{k - 1}.T", f"rod{k}.A")
        self._pin(f"slider-pin{k}", f"rod{k}.S", f"slider{k}.S")
        self.joints[f"way{k}"] = {
            "kind": "prismatic",
            "guide": f"ground.S{k}",
            "direction": 0.5 * math.pi,
            "slider": f"slider{k}.S",
        }

    def _bar(self, name: str, mass: float, **points: Point) -> None:
        self.bodies[name] = {"points": points, "uniform": "bar", "ends": list(points)[:2], "mass": mass}

    def _pin(self, name: str, first: str, second: str) -> None:
        self.joints[name] = {"kind": "revolute", "connects": [first, second]}


def large_mechanism(loops: int) -> dict[str, Any]:
    """Tables of a file of so many loops, with 2 loops + 2 links, the ground among them."""
    return dict(json.loads(json.dumps(LargeMechanism(loops).tables())))  # with lists, as a TOML file has them


DEEP = "bodies.rocker19.points.P.y"


@pytest.fixture(scope="module")
def largest() -> DescribedScene:
    return scene_from_tables(large_mechanism(24))


def with_wrong_length(scene: DescribedScene) -> DescribedScene:
    """With one length of a deep loop a thousandth off."""
    return scene.with_parameters(**{DEEP: scene.parameters[DEEP] + 3e-4})


def test_exact_motion_closes_every_joint_up_to_jerk(largest: DescribedScene) -> None:
    derivatives = largest.kinematics.derivatives(largest.kinematics.angles(90), 3)
    factorials = (1.0, 1.0, 2.0, 6.0)
    mechanism = largest.mechanism()
    bodies = pose_jets(mechanism, [d / f for d, f in zip(derivatives, factorials, strict=True)])
    for joint in mechanism.joints:
        for equation in joint_residual(joint, bodies):
            for order, left in enumerate(equation.coefficients):
                assert np.abs(left).max() < 1e-12 * max(1.0, np.abs(derivatives[order]).max()), (joint.name, order)


def test_wrong_length_in_deep_loop_is_detected(largest: DescribedScene) -> None:
    angles = largest.kinematics.angles(90)
    exact, other = (scene.motion(angles, scene.speed).points for scene in (largest, with_wrong_length(largest)))
    off = {name: np.abs(exact[name].position - other[name].position).max() for name in exact}
    assert off["P"] > 1e-5
    assert off["A"] < 1e-12  # the first loop knows nothing of it


def test_chain_loops_are_closed_one_at_a_time(largest: DescribedScene) -> None:
    factors = largest.kinematics._equations.elimination(largest.kinematics.start)
    assert len(factors.order.blocks) == 24
    assert max(len(rows) for rows, _ in factors.order.blocks) == 2
    assert len(machine_tree(largest).cuts) == 24


def test_triangular_blocks_merge_unmatched_rows() -> None:
    assert len(triangular_blocks({0: (0, 1), 1: (1, 2), 2: (2, 0)}, (0, 1, 2))) == 1
    assert len(triangular_blocks({0: (0, 1), 1: (0, 1), 2: (2, 0)}, (0, 1, 2))) == 2


@pytest.mark.slow
def test_engines_place_chain_and_detect_wrong_length(largest: DescribedScene) -> None:
    angles = largest.kinematics.angles(5)
    exact = largest.motion(angles, largest.speed).point("P").position
    for name in ("mujoco", "pymunk"):
        for scene, wrong in ((largest, False), (with_wrong_length(largest), True)):
            solved = engine_named(name).solve_kinematics(scene, angles).points["P"][0]
            off = np.abs(solved - exact).max() / largest.lengths["P"]
            assert off > 1e-5 if wrong else off < 1e-12, (name, off)


@pytest.mark.slow
def test_hardened_mujoco_runs_large_mechanism_accurately(largest: DescribedScene) -> None:
    engine = engine_named("mujoco")
    trajectory = run_in_one_piece(engine, largest, engine.presets["hardened"](largest, 500), 0.25)
    assert trajectory.outcome is Outcome.COMPLETED
    assert compare(trajectory, largest).worst("position") < 1e-8
    assert compare(trajectory, with_wrong_length(largest)).worst("position") > 1e-5


def test_many_pins_are_solved_sparsely_as_by_dense_matrices() -> None:
    mechanism = select_scene("four-bar-chain-15", ())[1].mechanism()
    sparse, dense = ConfigurationCurve(mechanism), ConfigurationCurve(mechanism)
    assert sparse._pins is not None  # negative control: few pins, and other joints, are not
    assert ConfigurationCurve(select_scene("four-bar-chain-14", ())[1].mechanism())._pins is None
    assert ConfigurationCurve(scene_from_tables(large_mechanism(20)).mechanism())._pins is None
    dense._pins = None
    start = sparse.start_point()
    assert np.abs(start - dense.start_point()).max() < 1e-14
    generator = np.random.default_rng(3)
    points = start + 0.01 * generator.standard_normal((4, start.shape[1]))
    border, second = (generator.standard_normal(points.shape) for _ in range(2))
    for coefficients in ([points], [points, border], [points, border, second]):
        found, expected = (curve.residual_coefficient(coefficients) for curve in (sparse, dense))
        np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-14)
    for transposed in (False, True):
        found, expected = (curve._factors(points, border).solve(second, transposed) for curve in (sparse, dense))
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
    # Two like rows: singular for both.
    for curve in (sparse, dense):
        assert not np.isfinite(curve._factors(points, curve.jacobian(points)[:, 0]).solve(second)).all()
