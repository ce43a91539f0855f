"""Runs of a model without an exact motion, in motion: of its actuators, along given laws, and of the file as it is."""

from __future__ import annotations

import copy
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np
from numpy.typing import NDArray

from conrod.engines.engine import STOCK
from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.exact.motion import Array
from conrod.exact.space.drive_laws import parse_drive_law
from conrod.mjcf.drawn_links import RunToDraw, draw_links, frame_indices
from conrod.mjcf.driving import break_off_reason
from conrod.mjcf.link_sketch import machine_box
from conrod.mjcf.loading import start_words
from conrod.models.inspection.actuator_kinds import TriedActuator, read_actuators
from conrod.models.inspection.actuator_results import SERVOS, ActuatorResult
from conrod.models.inspection.actuator_runs import prepare_trial
from conrod.models.inspection.moving_results import LawResponse
from conrod.report.drawing.moving_links import MovingLinks

MAX_ACTUATORS = 4  # that are drawn
OWN_SECONDS, MAX_OWN_STEPS = 3.0, 6000  # length of the file's own run
RUN_TIME = 0.5  # CPU time [s] after which a run is drawn as far as it came
FORCE_SECONDS, MAX_FORCE_STEPS = 1.0, 4000  # longest run of a force
FORCE_ROOM = 0.4  # of its range, that a force is run through
MOVES = 1e-3  # of the machine's size: a body that moves by more is seen to move
MAX_DISTANCE = 3.0  # from the machine, in its sizes: a body that falls further is drawn until it does


@dataclass
class PoseRecorder:
    """Coordinates (nq,) of a run at the steps that it is called at."""

    poses: list[Array] = field(default_factory=list)

    def __call__(self, data: mujoco.MjData) -> None:
        self.poses.append(data.qpos.copy())

    @property
    def steps(self) -> NDArray[np.intp]:
        """Numbers (K,) of `FRAMES` + 1 evenly spaced steps, or of all if these are fewer."""
        return frame_indices(len(self.poses))

    def frames(self) -> Array:
        """Coordinates (nq, K) at `steps`."""
        return np.array([self.poses[step] for step in self.steps.tolist()]).T


def draw_own_runs(
    model: mujoco.MjModel, start: mujoco.MjData, keyframe: int | None, actuators: Sequence[ActuatorResult]
) -> MovingLinks | None:
    """Draw the trials of a model's first actuators, and the file's own run if something moves in it; or None.

    Args:
        start: data at the start; it is not changed.
        keyframe: number of the keyframe that the start is; None for the model's own pose.
    """
    if not model.nv:
        return None
    every = read_actuators(model)
    tried = [(one, commands) for one, result in zip(every, actuators, strict=False)
             if not one.untried and (commands := list(_commands(model, one, result)))]  # fmt: skip
    runs = [_trial_run(model, start, one, commands, every) for one, commands in tried[:MAX_ACTUATORS]]
    steps = max(2, min(MAX_OWN_STEPS, round(OWN_SECONDS / float(model.opt.timestep))))
    own, seconds, broke = _record(model, copy.copy(start), lambda data: None, steps)
    places, moved = start_words(model, keyframe, np.array(start.ctrl).tolist()), _displacements(model, own)
    if not runs or broke or moved.max() > MOVES:
        near = max(2, int(np.argmax(moved > MAX_DISTANCE)) if np.any(moved > MAX_DISTANCE) else len(moved))
        seconds *= (near - 1) / max(1, len(moved) - 1)
        runs.append(RunToDraw(f"run as the file has it, from {places}", "", seconds, own[:, :near], broke))
    return draw_links(model, None, runs)


def draw_law_run(model: mujoco.MjModel, recorder: PoseRecorder, followed: Sequence[LawResponse]) -> MovingLinks | None:
    """Draw a run along given laws, over the positions that servos were commanded to; None if none was recorded.

    Other joints are where they are in the run.
    """
    if len(recorder.poses) < 2:
        return None
    step, frames, every = float(model.opt.timestep), recorder.frames(), read_actuators(model)
    commanded, servos = frames.copy(), 0
    for response in (one for one in followed if one.follows):
        servo = next((one for one in every if response.name == one.name), None) or next(
            (one for one in every if f"joint {response.name}" == one.drives and one.kind in SERVOS), None
        )
        if servo is not None and servo.joint is not None and servo.kind in SERVOS:
            place, servos = int(model.jnt_qposadr[servo.joint]), servos + 1
            law = parse_drive_law(response.law, servo.unit, float(recorder.poses[0][place]), response.name)
            commanded[place] = law.derivatives(np.asarray(step * recorder.steps, dtype=float))[0]
    words = ", ".join(f"{one.name} = {one.law}" for one in followed if one.follows)
    ended = next((one.broke for one in followed if one.broke), "")
    run = RunToDraw(words, STOCK, step * len(recorder.poses), frames, ended)
    return draw_links(model, commanded if servos else None, [run], reference="as commanded")


def _displacements(model: mujoco.MjModel, coordinates: Array) -> Array:
    """Largest displacement (K,) of a body since the first of some coordinates (nq, K), over the machine's size."""
    data, places, size = mujoco.MjData(model), list[Array](), 0.0
    for pose in coordinates.T:
        data.qpos[:] = pose
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        size = size or machine_box(model, data)[2]
        places.append(data.xipos.copy())
    return np.asarray(np.linalg.norm(np.array(places) - places[0], axis=2).max(axis=1) / size)


def _record(
    model: mujoco.MjModel, data: mujoco.MjData, act: Callable[[mujoco.MjData], None], steps: int
) -> tuple[Array, float, str]:
    """Run a model for some steps, or for `RUN_TIME`; return coordinates (nq, K), seconds, and why it broke off."""
    recorder, broke, begun = PoseRecorder(), "", time.process_time()
    with silence_warnings():
        for k in range(steps):
            act(data)
            recorder(data)
            mujoco.mj_step(model, data)
            if k % 16 == 0 and (broke := break_off_reason(model, data)):
                recorder.poses = [pose for pose in recorder.poses if np.all(np.isfinite(pose))]
                break
            if k % 16 == 0 and time.process_time() - begun > RUN_TIME:
                break
    return recorder.frames(), len(recorder.poses) * float(model.opt.timestep), broke


def _trial_run(
    model: mujoco.MjModel, start: mujoco.MjData, one: TriedActuator, commands: Sequence[tuple[float, float]],
    every: Sequence[TriedActuator],
) -> RunToDraw:  # fmt: skip
    """Run an actuator's commands (control, time [s]) again, to be drawn."""
    bench = prepare_trial(model, start, one, every)
    data, times = copy.copy(bench.data), np.cumsum([seconds for _, seconds in commands])
    begin = float(data.time)

    def act(data: mujoco.MjData) -> None:
        row = int(np.searchsorted(times, data.time - begin, side="right"))
        control = commands[min(row, len(commands) - 1)][0]
        if bench.model.actuator_ctrllimited[one.control]:
            control = float(np.clip(control, *bench.model.actuator_ctrlrange[one.control]))
        data.ctrl[one.control] = control

    frames, seconds, broke = _record(bench.model, data, act, max(2, round(float(times[-1]) / bench.step)))
    return RunToDraw(f"{one.name}, as it was tried", "", seconds, frames, broke)


def _commands(model: mujoco.MjModel, one: TriedActuator, result: ActuatorResult) -> Iterator[tuple[float, float]]:
    """Yield the controls of an actuator's trial, and how long [s] each is given."""
    if one.kind == "position":
        for response in result.responses:
            yield one.control_for(response.target), response.seconds
    elif one.kind in ("velocity", "intvelocity"):
        per_control = one.gain / (one.gear * (one.stiffness if one.kind == "intvelocity" else one.damping))
        for response in result.responses:
            yield response.target / per_control, response.seconds
    elif result.acceleration and result.full is not None and result.span is not None:
        room = FORCE_ROOM * (result.span[1] - result.span[0])
        seconds = float(np.sqrt(2.0 * room / abs(result.acceleration))) + one.delay
        yield result.full, min(seconds, FORCE_SECONDS, MAX_FORCE_STEPS * float(model.opt.timestep))
