"""Spatial machines: closed forms by print, and the solver of any model's loops held against them.

Neither the closed form nor the solver knows of the other; the model is between them.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from four_bars import driven

from conrod.exact.motion import Array
from conrod.exact.space.drive_laws import parse_drive_law
from conrod.exact.space.mobility import count_mobility
from conrod.exact.space.motion import SpatialMotion
from conrod.scenes.space import MACHINES, SpatialMachine

DEGREE = math.pi / 180.0


def laws(machine: SpatialMachine, times: Array, order: int = 0) -> dict[str, Array]:
    """Coordinate of each driven joint, with derivatives by time: (order + 1, T)."""
    units = {joint: "m" if "mm" in law else "rad" for joint, law in machine.drives.items()}
    made = {joint: parse_drive_law(law, units[joint], 0.0, joint) for joint, law in machine.drives.items()}
    return {joint: law.derivatives(times)[: order + 1] for joint, law in made.items()}


# -- closed forms ------------------------------------------------------------------------------------------------------


# The freedoms of its model, idle spins of rods included; and a parameter that is a little different.
KNOWN = {
    "cardan": (1, {"bend": 30.1}),
    "double-cardan": (1, {"phasing": 0.1}),
    "double-cardan-misphased": (1, {"bend": 30.1}),
    "spherical-four-bar": (1, {"coupler": 60.1}),
    "rssr": (1, {"rod": 0.42 * 1.001}),
    "rssr-idle-spin": (2, {"rod": 0.42 * 1.001}),
    "bennett": (1, {"other_twist": 75.1}),
    "sarrus": (1, {"upper": 0.2 * 1.001}),
    "delta": (3, {"rod": 1.244 * 1.001}),
    "stewart": (6, {"platform": 0.3 * 1.001}),
    "tilted-slider-crank": (1, {"rod": 0.3 * 1.001}),
}
ANGLES = ("bend", "phasing", "coupler", "other_twist")


@pytest.mark.parametrize(("name", "power"), [("cardan", 1), ("double-cardan", 0), ("double-cardan-misphased", 2)])
def test_double_cardan_output_fluctuates_with_phasing(name: str, power: int) -> None:
    # Uicker, Pennock, Shigley: between cos and 1 / cos of the angle; two joints out of phase multiply, in phase cancel.
    machine, quarter_turns = MACHINES[name](), np.arange(8) * 0.125
    arm = machine.points(laws(machine, quarter_turns, 1))["output_arm"]
    ratio = np.linalg.norm(arm[1], axis=-1) / 0.04 / (2.0 * math.pi)
    bend = math.cos(30 * DEGREE) ** power
    assert (ratio.min(), ratio.max()) == pytest.approx((bend, 1.0 / bend), abs=1e-13)


@pytest.mark.parametrize(
    ("angles", "place"), [((0.0, 0.0, 0.0), (0.0, 0.0, -1.065)), ((10.0, 20.0, 30.0), (0.108, -0.180, -1.244))]
)
def test_delta_position_matches_williams(angles: tuple[float, ...], place: tuple[float, ...]) -> None:
    # Williams (2016), The Delta Parallel Robot: Kinematics Solutions, forward position examples, ABB FlexPicker. Its
    # dimensions are printed to a millimetre, and so are its results.
    drives = {f"input_{k}": np.array([[angle * DEGREE]]) for k, angle in enumerate(angles, 1)}
    assert MACHINES["delta"]().points(drives)["platform"][0, 0] == pytest.approx(place, abs=1e-3)


# -- the solver --------------------------------------------------------------------------------------------------------

# From one pose to another a fifth of a period on, where no law has a rate or an acceleration of 0.
DURATION = 0.2
SAMPLES = np.linspace(0.0, DURATION, 7)
# Of travel, per period^k: of position, velocity, acceleration and jerk.
BARS = (1e-12, 1e-12, 1e-12, 1e-9)


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
def test_spatial_solver_matches_closed_form(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conrod.exact.space.motion.POSES", 12)  # a fifth of a period needs no more
    machine, (freedoms, change) = MACHINES[name](), KNOWN[name]
    tree = driven(machine.mjcf, dict(machine.drives), DURATION)
    motion = tree.motion(SAMPLES)
    assert (errors(machine, motion) < BARS).all()
    counted = count_mobility(tree)
    assert counted.remaining_dof == freedoms
    assert bool(counted.idle) == (name == "rssr-idle-spin")
    # Negative control: a link 0.1 % longer, or an angle 0.1 degrees larger, is another machine.
    other = {key: math.radians(value) if key in ANGLES else value for key, value in change.items()}
    assert errors(MACHINES[name](**other), motion)[0] > 1e-5
