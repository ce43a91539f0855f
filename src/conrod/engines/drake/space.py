"""Drake on machines in space: a tree of bodies, loops closed by constraints or bushings, drives by flywheels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from conrod.engines.capabilities import TIMED_REFERENCE
from conrod.engines.drake import DRAKE_PRESETS
from conrod.engines.drake.plant import CLOSURES, JOINTS, build_plant
from conrod.engines.drake.stepping import DrakeSimulation
from conrod.engines.space import SpatialRun, SpatialStart, constant_rate
from conrod.exact.motion import Array
from conrod.exact.space import SpatialPoint


def refusal_in_space(start: SpatialStart, preset: str) -> str | None:
    """Return the reason why Drake is not given a machine in space, or None."""
    tree = start.tree
    if other := sorted({joint.kind for joint in tree.joints} - {*JOINTS}):
        return f"drake in space is given hinges, slides and balls, no {' or '.join(other)} joints"
    if other := sorted({closure.kind for closure in tree.closures} - {*CLOSURES}):
        return f"drake in space is given loops closed by a connect or a weld, no {' or '.join(other)}"
    return None


def stepper_in_space(start: SpatialStart, preset: str) -> DrakeSimulation:
    """A machine in space in Drake that starts in its exact state; a call advances it by some steps."""
    # A preset's rule is asked of a machine in the plane, whose step is another.
    steps = max(2, round(start.period / start.step))
    settings = replace(DRAKE_PRESETS[preset](TIMED_REFERENCE, steps), timestep=start.step)
    laws, coordinates = start.machine.laws, start.exact.coordinates[:, 0]
    made = build_plant(start.tree, laws, coordinates, start.step, settings)
    vary = any(constant_rate(law) is None for law in laws.values())
    simulation = DrakeSimulation(made, start.step, settings, laws if vary else None)
    made.place(start.tree, simulation.context, coordinates, start.exact.rates[0, :, 0])
    return simulation


def run_in_space(start: SpatialStart, preset: str, steps: int, every: int = 1) -> SpatialRun:
    """Run a machine from its exact state, and record its points at the start and after each `every` steps."""
    simulation = stepper_in_space(start, preset)
    numbers = sorted({point.body for point in start.points.values()})
    rows = [simulation.made.body_states(simulation.context, numbers)]
    for k in range(1, steps + 1):
        simulation(1)
        if simulation.failure:
            break
        if k % every == 0:
            rows.append(simulation.made.body_states(simulation.context, numbers))
    states = np.array(rows)
    times = start.step * every * np.arange(len(rows), dtype=float)
    points = {name: point_motion(states[:, numbers.index(point.body)], point) for name, point in start.points.items()}
    return SpatialRun(times, points, simulation.failure)


def point_motion(states: Array, point: SpatialPoint) -> Array:
    """Position, velocity and acceleration (3, T, 3) of a point of a body from its motion (T, 8, 3).

    The point is at the arm r from the body's origin: v = v_o + w x r, a = a_o + w' x r + w x (w x r).
    """
    arm = np.einsum("tkj,k->tj", states[:, 1:4], point.offset)
    spin = states[:, 5]
    turning = np.cross(spin, arm)
    bend = states[:, 6] + np.cross(states[:, 7], arm) + np.cross(spin, turning)
    return np.array([states[:, 0] + arm, states[:, 4] + turning, bend])
