"""A scene driven by the engine's own velocity actuator, as a user would set it up, with nothing of conrod's drive.

It stands beside `stock`, to which the drive was added. Errors are taken at the crank angle reached, as everywhere; what
the actuator makes of the speed is seen in the drive's ripple and in the phase. It is measured, and never judged.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from conrod.engines import Engine
from conrod.engines.capabilities import OwnMotor
from conrod.engines.engine import STOCK, step_length
from conrod.engines.tracks import FreeRun
from conrod.errors import InvalidInput
from conrod.runs.comparison import Stretch
from conrod.runs.outcome import judge
from conrod.runs.run_errors import RunErrors
from conrod.runs.trajectory import BodyStates, BodyTracks, Instants, Outcome, PointTracks, Track, Trajectory
from conrod.scenes import Scene
from conrod.studies.validation.plan import DrawnPoses, Plan, started
from conrod.studies.validation.results import ValidationResult

OWN_MOTOR = "own motor"  # in the place of a preset's name
STEPPED = slice(2, None)  # samples whose acceleration, a central difference, has none of the exact start in it


def validate_own_motor(name: str, scene: Scene, engine: Engine[Any], plan: Plan) -> ValidationResult:
    """Measure the engine with its own actuator."""
    assert isinstance(engine, OwnMotor)
    steps = plan.steps(scene)
    start, revolutions = plan.stretch(scene)
    empty = replace(started(name, scene, engine, OWN_MOTOR, plan), mode="motor", revolutions=revolutions)
    poses, slopes = scene.kinematics.derivatives(np.array([start]), 1)
    try:
        run, actuator = engine.motor_run(
            scene, step_length(scene, steps), round(steps * revolutions), poses[0], slopes[0] * scene.speed
        )
    except InvalidInput as error:
        return replace(empty, outcome=Outcome.UNSUPPORTED.slug, reason=str(error))
    empty = replace(empty, settings=actuator)
    with np.errstate(all="ignore"):
        found = _trajectory(scene, engine, run, start, revolutions)
    if found.outcome is not Outcome.COMPLETED:
        return replace(empty, outcome=found.outcome.slug, reason=found.reason)
    errors, bodies, whole = RunErrors(), DrawnPoses(scene, steps), Stretch(found, scene)
    errors.add(whole)
    bodies.add(whole)
    return replace(empty, **errors.found(), poses=bodies.errors)


def _trajectory(scene: Scene, engine: Engine[Any], run: FreeRun, start: float, revolutions: float) -> Trajectory:
    """The run as one at constant speed is reported; accelerations are differences of velocities."""
    kinematics, speed = scene.kinematics, scene.speed
    mechanism, accelerations = kinematics.mechanism, np.gradient(run.rates, run.times, axis=0)
    crank, driver = 3 * mechanism.body_index[mechanism.crank] + 2, mechanism.driver
    angle, rate, acceleration = (driver.sense * motion[:, crank] for motion in (run.poses, run.rates, accelerations))
    instants = Instants(run.times + start / speed, angle - driver.sense * driver.start, rate, acceleration)
    motion = [run.poses, run.rates, accelerations]
    states = BodyStates(instants, *motion)
    stepped = BodyStates(instants[STEPPED], *(values[STEPPED] for values in motion))
    tracks = {
        name: PointTracks(Track(instants, x), Track(instants, v), Track(stepped.instants, a[STEPPED]))
        for name, (x, v, a) in kinematics.point_derivatives(motion).items()
    }
    bodies = BodyTracks(states, states, stepped)
    verdict = judge(kinematics, bodies, speed)
    settings = engine.presets[STOCK](scene, round(2.0 * np.pi / abs(speed) / float(run.times[1])))
    return Trajectory(
        engine.name, engine.version, settings, speed, revolutions, verdict.outcome, verdict.reason, tracks, bodies
    )
