"""The solver of any model's loops, held against spatial machines in closed form: neither knows of the other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from spatial_poses import Model, driven

from conrod.exact.motion import Array
from conrod.exact.space.laws import law_of
from conrod.exact.space.mobility import mobility
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.mjcf.loops.reading import tree_of
from conrod.scenes.space import MACHINES, SpatialMachine

# From one pose to another a fifth of a period on, where no law has a rate or an acceleration of 0.
DURATION = 0.2
TIMES = np.linspace(0.0, DURATION, 7)
# Of travel, per period^k: of position, velocity, acceleration and jerk.
BARS = (1e-12, 1e-12, 1e-12, 1e-9)
# A parameter that is a little different, of each machine.
CHANGES = {
    "cardan": {"bend": 30.1}, "double-cardan": {"phasing": 0.1}, "double-cardan-misphased": {"bend": 30.1},
    "spherical-four-bar": {"coupler": 60.1}, "rssr": {"rod": 0.42 * 1.001}, "rssr-idle-spin": {"rod": 0.42 * 1.001},
    "bennett": {"other_twist": 75.1}, "sarrus": {"upper": 0.2 * 1.001}, "delta": {"rod": 1.244 * 1.001},
    "stewart": {"platform": 0.3 * 1.001}, "tilted-slider-crank": {"rod": 0.3 * 1.001},
}  # fmt: skip
ANGLES = ("bend", "phasing", "coupler", "other_twist")


def solved(machine: SpatialMachine) -> tuple[DrivenTree, SpatialMotion]:
    model = Model(machine).model
    start = model.qpos0.copy()
    laws = {
        joint: law_of(law, "m" if law.startswith("sine") and "mm" in law else "rad", 0.0, joint)
        for joint, law in machine.drives.items()
    }
    driven_tree = DrivenTree(tree_of(model, start), laws)
    driven_tree.go(driven_tree.closed(start[:, None], 0.0)[0], DURATION)
    return driven_tree, driven_tree.motion(TIMES)


def errors(machine: SpatialMachine, motion: SpatialMotion) -> Array:
    """Largest of all points, of travel by period^k, (4,)."""
    found = np.zeros(4)
    for name, exact in machine.points(driven(machine, TIMES, 3)).items():
        point = motion.points[name]
        travel = max(np.ptp(exact[0], axis=0).max(), 1e-3)
        for k, values in enumerate((point.position, point.velocity, point.acceleration, point.jerk)):
            off = np.abs(values - exact[k]).max() / travel / (2.0 * math.pi) ** k
            found[k] = max(found[k], off)
    return found


@pytest.mark.parametrize("name", MACHINES)
def test_the_solver_moves_a_model_as_its_closed_form_says(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conrod.exact.space.motion.POSES", 12)  # a fifth of a period needs no more
    machine = MACHINES[name]()
    tree, motion = solved(machine)
    assert (errors(machine, motion) < BARS).all()
    counted = mobility(tree)
    assert counted.left == machine.degrees_of_freedom
    assert bool(counted.idle) == (name == "rssr-idle-spin")
    for joint, exact in machine.joints(driven(machine, TIMES)).items():
        address = next(one.coordinate for one in tree.tree.joints if one.name == joint)
        assert np.sin(0.5 * (motion.coordinates[address] - exact[0])) == pytest.approx(0.0, abs=1e-12), joint
    # Negative control: a link 0.1 % longer, or an angle 0.1 degrees larger, is another machine.
    change = {key: math.radians(value) if key in ANGLES else value for key, value in CHANGES[name].items()}
    assert errors(MACHINES[name](**change), motion)[0] > 1e-5
