"""Trial of a model's actuators: each is commanded through its range, and its response measured."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.exact.motion import Array
from conrod.models.inspection.actuator_kinds import TriedActuator, read_actuators, value_range
from conrod.models.inspection.actuator_results import ActuatorResult, StepResponse
from conrod.models.inspection.actuator_runs import (
    TrialBench,
    TrialRun,
    obstacles,
    prepare_trial,
    run_trial,
)
from conrod.models.inspection.stable_steps import search_steps
from conrod.models.inspection.step_measures import is_settled, measure_step

INSET = 0.1  # of a range, that its ends are not gone to: there the range's own limits would act
# Length of a response: so many of the slowest time constants, within bounds [s] and numbers of steps.
TIME_CONSTANTS, MIN_PHASE, MAX_PHASE, MIN_STEPS, MAX_STEPS = 12.0, 0.05, 4.0, 50, 20_000
FORCE_ROOM = 0.4  # of the room ahead, that a force is run for
SPEED_TIME = 1.0  # [s] in which a commanded speed without a range crosses the range of its joint
HOLD_POSES = 61  # of a joint's range, at which it is asked whether a force holds it
MAX_SEARCHES = 12  # actuators whose time step is searched: those whose response is the fastest
MAX_TRIED_AGAIN = 4  # actuators, with other settings
CPU_TIME = 6.0  # [s] after which no further actuator is tried


def try_actuators(
    model: mujoco.MjModel, start: mujoco.MjData, progress: Callable[[str], object] = lambda name: None
) -> tuple[ActuatorResult, ...]:
    """Command each actuator of a model through its range from a start, and measure its response.

    An actuator that is not reached within `CPU_TIME` has a result that says so.

    Args:
        start: data at the start, as `conrod.mjcf.loading.data_at_start` gives it; it is not changed.
        progress: called with the name of each actuator before it is tried.
    """
    every, found, begun = read_actuators(model), list[ActuatorResult](), time.process_time()
    if model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_ACTUATION):
        every = [replace(one, untried="actuation is switched off in <flag>") for one in every]
    searched, reached = 0, len(every)
    for number, one in enumerate(every):
        result = ActuatorResult(one.name, one.kind, one.drives, one.unit, remark=f"not tried: {one.untried}")
        if not one.untried:
            if reached < number or time.process_time() - begun > CPU_TIME:
                reached = min(reached, number)
                result = replace(result, remark=f"not tried: the first {reached} took {CPU_TIME:.0f} s")
            else:
                progress(one.name)
                result = _try_one(model, start, one, every, search=searched < MAX_SEARCHES)
                searched += result.steps is not None
        found.append(result)
    return tuple(found)


def _try_one(
    model: mujoco.MjModel, start: mujoco.MjData, one: TriedActuator, every: list[TriedActuator], *, search: bool
) -> ActuatorResult:
    """Try an actuator by the method for its kind.

    What is held still is heavy, and may throw light parts about that overlap it: a trial that breaks off is made again
    with all joints free.
    """
    bench = prepare_trial(model, start, one, every)
    found = _try_on(bench, one, search=search)
    if found.broke and bench.held:
        free = _try_on(prepare_trial(model, start, one, every, hold=False), one, search=search)
        return found if free.broke else free
    return found


def _try_on(bench: TrialBench, one: TriedActuator, *, search: bool) -> ActuatorResult:
    """Try an actuator on its bench."""
    result = ActuatorResult(
        one.name, one.kind, one.drives, one.unit, bench.inertia or None, bench.load / one.gear,
        one.limit if math.isfinite(one.limit) else None,
        remark=_held_words(bench.held),
    )  # fmt: skip
    if not bench.inertia:
        why = "it moves nothing at the start: its gear, or the closures there (a dead centre?), leave it no freedom"
        return replace(result, remark=why)
    if one.kind == "position":
        return _try_position(bench, result, search=search)
    if one.kind in ("velocity", "intvelocity"):
        return _try_speed(bench, result, search=search)
    if one.kind == "damper":
        return _try_damper(bench, result, search=search)
    if one.kind in ("motor", "cylinder", "muscle"):
        return _try_force(bench, result, search=search)
    return replace(result, remark=f"not tried: what its control means is not known (kind {one.kind})")


def still_bear(
    model: mujoco.MjModel, start: mujoco.MjData, results: Sequence[ActuatorResult]
) -> Callable[[mujoco.MjModel], bool]:
    """Return whether actuators whose trial did not break off complete it in the model with other settings, too.

    Harder loops couple what they join more closely, and the largest step that an actuator bears is another one.
    """
    every = read_actuators(model)
    sound = [one for one, found in zip(every, results, strict=False) if found.steps is not None and not found.broke]

    def bears(edited: mujoco.MjModel) -> bool:
        return not any(_try_one(edited, start, one, every, search=False).broke for one in sound[:MAX_TRIED_AGAIN])

    return bears


def _held_words(held: tuple[str, ...]) -> str:
    """Name joints that are held still during a trial; empty if none is."""
    return f"{held[0] if len(held) == 1 else f'{len(held)} other joints'} held still" if held else ""


def settling_seconds(bench: TrialBench, stiffness: float, damping: float) -> float:
    """Settling time [s]: 12 time constants of m y'' + d y' + k y = 0 and of the activation.

    Args:
        stiffness, damping: of the actuator, along its coordinate.
    """
    model, n = bench.model, bench.direction
    damping += float(np.sum(model.dof_damping * n**2))
    springs = np.array(model.jnt_stiffness)[model.dof_jntid]
    stiffness += float(np.sum(springs * n**2))
    half, rest = 0.5 * damping / bench.inertia, stiffness / bench.inertia
    root = half**2 - rest
    slowest = half if root < 0.0 else (rest / (half + math.sqrt(root)) if rest else 2.0 * half)
    seconds = TIME_CONSTANTS * (one_over(slowest) + bench.actuator.delay)
    return float(np.clip(seconds, max(MIN_PHASE, MIN_STEPS * bench.step), _longest_phase(bench)))


def one_over(rate: float) -> float:
    """Return the time constant [s] of a rate [1/s]; infinite for 0."""
    return 1.0 / rate if rate > 0.0 else math.inf


def _longest_phase(bench: TrialBench) -> float:
    return max(min(MAX_PHASE, MAX_STEPS * bench.step), MIN_STEPS * bench.step)


# -- positions ---------------------------------------------------------------------------------------------------------


def _try_position(bench: TrialBench, result: ActuatorResult, *, search: bool) -> ActuatorResult:
    """Hold a servo at its start, then command both ends of its range; measure the responses."""
    one, extent = bench.actuator, float(bench.model.stat.extent)
    whole, remark = value_range(bench.model, one, bench.start, extent)
    inset = INSET * (whole[1] - whole[0])
    low, high = whole[0] + inset, whole[1] - inset
    gear = one.gear
    seconds = settling_seconds(bench, one.stiffness * gear**2, one.damping * gear**2)
    begin = float(np.clip(bench.start, *whole))
    ends = (high, low) if abs(high - begin) >= abs(begin - low) else (low, high)
    data, responses, before, broke, sag = copy.copy(bench.data), list[StepResponse](), begin, "", 0.0
    for target in (begin, *ends):
        set_control(bench, data, target)
        run = _run_until_settled(bench, data, seconds, whole[1] - whole[0], target - before)
        if run.broke:
            broke = run.broke
            break
        if target == begin and not responses:
            sag = float(run.values[-max(1, len(run.values) // 10) :].mean()) - begin
        else:
            near = abs(run.values[-1] - target) <= 0.05 * abs(target - before)
            # What swings touches this and that: what it touches at the last instant does not hold it off.
            rests = is_settled(run.values, target - before)
            met = obstacles(bench, copy.copy(data)) if rests and not near else ()
            responses.append(
                measure_step(
                    run.values, run.forces, bench.step, responses[-1].final if responses else begin + sag, target, met
                )
            )
        before = target
    result = replace(result, sag=None if broke and not responses else sag, responses=tuple(responses), broke=broke)
    result = replace(
        result,
        remark="; ".join(filter(None, (result.remark, remark))),
        damping_hint=_damping_hint(bench, result),
    )
    if not search:
        return result
    bounds = search_steps(bench, lambda data: set_control(bench, data, ends[0]), seconds, whole[1] - whole[0])
    return replace(result, steps=bounds)


def set_control(bench: TrialBench, data: mujoco.MjData, value: float) -> None:
    """Command a servo to a value of its coordinate by its control alone, within its control's range."""
    one, model = bench.actuator, bench.model
    control = one.control_for(value)
    if model.actuator_ctrllimited[one.control]:
        control = float(np.clip(control, *model.actuator_ctrlrange[one.control]))
    data.ctrl[one.control] = control


def _damping_hint(bench: TrialBench, result: ActuatorResult) -> float | None:
    """The damping gain kv = 2 sqrt(kp m) - d of critical damping; None if the servo's is as large."""
    one, n = bench.actuator, bench.direction
    passive = float(np.sum(bench.model.dof_damping * n**2))
    critical = 2.0 * math.sqrt(one.stiffness * one.gear**2 * bench.inertia)
    wanted = (critical - passive) / one.gear**2
    return wanted if wanted > one.damping else None


def _run_until_settled(bench: TrialBench, data: mujoco.MjData, seconds: float, span: float, move: float) -> TrialRun:
    """Run in pieces of some seconds until the response settles or the longest run is over."""
    steps, most = max(2, round(seconds / bench.step)), round(_longest_phase(bench) / bench.step)
    parts, done = [run_trial(bench, data, steps, span)], steps
    size = abs(move) or span
    while not parts[-1].broke and done + steps <= most and not is_settled(_concatenate(parts, "values"), size):
        parts.append(run_trial(bench, data, steps, span))
        done += steps
    values, rates, forces = (_concatenate(parts, name) for name in ("values", "rates", "forces"))
    return TrialRun(values, rates, forces, parts[-1].broke)


def _concatenate(parts: list[TrialRun], name: str) -> Array:
    """Concatenate a field (T,) of consecutive runs."""
    return np.concatenate([getattr(part, name) for part in parts])


# -- speeds ------------------------------------------------------------------------------------------------------------


def _try_speed(bench: TrialBench, result: ActuatorResult, *, search: bool) -> ActuatorResult:
    """Command a speed of 0, then one that stays inside the range of the joint."""
    one, model = bench.actuator, bench.model
    whole, remark = value_range(model, one, bench.start, float(model.stat.extent))
    up, down = whole[1] - bench.start, bench.start - whole[0]
    room = (1.0 - INSET) * max(up, down, 1e-9)
    gear, is_servo = one.gear, one.kind == "intvelocity"
    seconds = settling_seconds(bench, one.stiffness * gear**2 if is_servo else 0.0, one.damping * gear**2)
    factor = 1.0 if is_servo else one.gain / (one.damping * gear)  # speed by unit control
    per_control = factor if not is_servo else one.gain / (one.stiffness * gear)
    speed = min(room / SPEED_TIME, room / seconds)
    limited = bool(model.actuator_ctrllimited[one.control])
    if limited:
        ends = per_control * np.array(model.actuator_ctrlrange[one.control])
        speed = min(speed, float(ends.max() if up >= down else -ends.min()))
    if not speed > 0.0:
        return replace(
            result,
            remark=f"not tried: its controls have no speed to the side where there is room{remark and '; '}{remark}",
        )
    speed *= 1.0 if up >= down else -1.0
    data, span = copy.copy(bench.data), whole[1] - whole[0]
    steps = max(2, round(seconds / bench.step))
    rest = run_trial(bench, data, steps, span)
    if rest.broke:
        return _add_stable_steps(bench, replace(result, broke=rest.broke), lambda d: None, seconds, span, search)
    drift = float(rest.rates[-max(1, len(rest.rates) // 10) :].mean())
    data.ctrl[one.control] = speed / per_control
    run = run_trial(bench, data, steps, span)
    responses = () if run.broke else (measure_step(run.rates, run.forces, bench.step, drift, speed),)
    if responses and not responses[0].is_reached:
        responses = (replace(responses[0], obstacles=obstacles(bench, copy.copy(data))),)
    result = replace(
        result, sag=drift, responses=responses, broke=run.broke, remark="; ".join(filter(None, (result.remark, remark)))
    )

    def command(data: mujoco.MjData) -> None:
        data.ctrl[one.control] = speed / per_control

    return _add_stable_steps(bench, result, command, seconds, span, search)


def _add_stable_steps(
    bench: TrialBench, result: ActuatorResult, command: Callable[[mujoco.MjData], None], seconds: float, span: float,
    search: bool = True,
) -> ActuatorResult:  # fmt: skip
    """Add the largest stable time steps to a result, if they are to be searched."""
    return replace(result, steps=search_steps(bench, command, seconds, span)) if search else result


# -- forces ------------------------------------------------------------------------------------------------------------


def _largest_control(bench: TrialBench) -> float:
    """The control to try a force with: the end of its range further from 0, or 1 without a range."""
    one, model = bench.actuator, bench.model
    if model.actuator_ctrllimited[one.control]:
        low, high = model.actuator_ctrlrange[one.control]
        return float(high if abs(high) >= abs(low) else low)
    return 1.0


def _try_force(bench: TrialBench, result: ActuatorResult, *, search: bool) -> ActuatorResult:
    """Apply a force's largest control; measure its acceleration and the range where it holds its load."""
    one, model = bench.actuator, bench.model
    whole, remark = value_range(model, one, bench.start, float(model.stat.extent))
    full, span = _largest_control(bench), whole[1] - whole[0]
    data = copy.copy(bench.data)
    data.ctrl[one.control] = full
    if one.activation is not None:
        data.act[one.activation] = full
    with silence_warnings():
        mujoco.mj_forward(model, data)
    push = float(data.actuator_force[one.output]) * one.gear
    acceleration = (push - bench.load) / bench.inertia
    limit = min(one.limit, abs(float(data.actuator_force[one.output])))
    holds = _holding_range(bench, limit, whole) if one.kind != "muscle" else None
    ahead = (whole[1] - bench.start) if acceleration > 0.0 else (bench.start - whole[0])
    seconds = math.sqrt(2.0 * FORCE_ROOM * max(ahead, INSET * span) / max(abs(acceleration), 1e-9)) + one.delay
    seconds = float(np.clip(seconds, MIN_STEPS * bench.step, _longest_phase(bench)))
    data = copy.copy(bench.data)
    data.ctrl[one.control] = full
    run = run_trial(bench, data, max(2, round(seconds / bench.step)), span)
    limited = bool(model.actuator_ctrllimited[one.control]) or math.isfinite(one.limit)
    result = replace(
        result, acceleration=acceleration, full=full, broke=run.broke, limit=limit if limited else None,
        holds=holds if limited else None, span=whole,
        remark="; ".join(filter(None, (result.remark, remark if holds is not None else ""))),
    )  # fmt: skip

    def command(data: mujoco.MjData) -> None:
        data.ctrl[one.control] = full

    # A force has no loop of its own that a step could make unstable.
    return _add_stable_steps(bench, result, command, seconds, span, search=search and bool(run.broke))


def _holding_range(bench: TrialBench, limit: float, whole: tuple[float, float]) -> tuple[float, float] | None:
    """Values about the start between which a force holds its joint at rest; None in a loop, or without a joint.

    Static equilibrium: the force at the joint is the bias force less the passive one at rest.
    """
    one, model = bench.actuator, bench.model
    if one.joint is None or np.any(model.eq_active0):
        return None
    data, dof, place = copy.copy(bench.data), int(model.jnt_dofadr[one.joint]), int(model.jnt_qposadr[one.joint])
    values, held = np.linspace(*whole, HOLD_POSES), list[bool]()
    with silence_warnings():
        for value in values.tolist():
            data.qpos[place], data.qvel[:] = value, 0.0
            mujoco.mj_fwdPosition(model, data)
            mujoco.mj_fwdVelocity(model, data)
            held.append(bool(abs(data.qfrc_bias[dof] - data.qfrc_passive[dof]) <= limit * abs(one.gear)))
    nearest = int(np.abs(values - bench.start).argmin())
    if not held[nearest]:
        return (float(values[nearest]), float(values[nearest]))
    low = high = nearest
    while low > 0 and held[low - 1]:
        low -= 1
    while high < HOLD_POSES - 1 and held[high + 1]:
        high += 1
    return (whole[0] if low == 0 else float(values[low]), whole[1] if high == HOLD_POSES - 1 else float(values[high]))


def _try_damper(bench: TrialBench, result: ActuatorResult, *, search: bool) -> ActuatorResult:
    """Brake a moving joint with the damper's largest control."""
    one, model = bench.actuator, copy.copy(bench.model)
    model.opt.gravity[:] = 0.0  # weight goes on pulling at what a damper brakes
    bench = replace(bench, model=model)
    whole, _ = value_range(model, one, bench.start, float(model.stat.extent))
    full, span = _largest_control(bench), whole[1] - whole[0]
    damping = -float(model.actuator_gainprm[one.number, 2]) * full * one.gear**2
    seconds, data = settling_seconds(bench, 0.0, damping), copy.copy(bench.data)
    speed = 0.2 * span / min(seconds, SPEED_TIME)

    def command(data: mujoco.MjData) -> None:
        data.ctrl[one.control], data.qvel[:] = full, speed * bench.direction

    command(data)
    run = run_trial(bench, data, max(2, round(seconds / bench.step)), span)
    response = () if run.broke else (measure_step(run.rates, run.forces, bench.step, speed, 0.0),)
    return _add_stable_steps(
        bench, replace(result, responses=response, broke=run.broke), command, seconds, span, search
    )
