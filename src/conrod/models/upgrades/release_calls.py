"""What is called in the process of a release of MuJoCo: a model's own run, and single steps from given states.

Old releases run this module, so it asks little of them: a state is set part by part, as the layout of `mj_setState`
changes between releases.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from functools import lru_cache, partial
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.execution.paired_timing import Block, cpu_time
from conrod.mjcf.loading import data_at_start, load_model, name_or_number, start_words
from conrod.mjcf.runs import break_reason, looping_stepper, state_of
from conrod.models.upgrades.results import ModelRun, ReleaseRun, StepTerms
from conrod.user_files.files import check_readable

MAX_SAMPLES, MAX_STEPS = 400, 100_000
# All that the next step depends on.
STATE_FIELDS = ("time", "qpos", "qvel", "act", "qacc_warmstart", "ctrl", "mocap_pos", "mocap_quat")
SPARSE_FREEDOMS = 60  # degrees of freedom from which MuJoCo's automatic choice is the sparse Jacobian
FORCES = ("qfrc_bias", "qfrc_passive", "qfrc_actuator", "qfrc_constraint")
# Fields of the compiled model that the motion depends on. `invweight0` follows from the others and scales softness.
FIELD_PREFIXES = ("body_", "dof_", "jnt_", "geom_", "eq_", "tendon_", "wrap_", "actuator_", "pair_", "qpos")
NO_PHYSICS = ("_rgba", "_user", "_matid", "_group", "_bvhadr", "_bvhnum", "_plugin", "_aabb", "_rbound", "tree", "adr")
OPTION_FIELDS = (
    "timestep", "integrator", "cone", "jacobian", "solver", "iterations", "ls_iterations", "tolerance", "impratio",
    "gravity", "wind", "density", "viscosity", "disableflags", "enableflags", "noslip_iterations",
)  # fmt: skip


def run_model(request: ModelRun, perturbed: bool = False) -> ReleaseRun:
    """Run a model with its file's settings; record states, bodies' positions and contacts.

    Args:
        perturbed: start one bit off, in all coordinates and rates.

    Raises:
        InvalidInput: this release cannot load the file.
    """
    model, data, _ = _start(request)
    if perturbed:
        _set_state(data, {name: rows[0] for name, rows in _perturb(_stack([_state(data)])).items()})
    steps = steps_of(request, float(model.opt.timestep))
    every = max(1, -(-steps // MAX_SAMPLES))
    states, bodies, contacts, seen = [_state(data)], [_positions(model, data)], 0, mujoco.MjData(model)
    with silence_warnings():
        for _ in range(steps // every):
            mujoco.mj_step(model, data, every)
            if break_reason(data):
                break
            states.append(_state(data))
            _set_state(seen, states[-1])
            bodies.append(_positions(model, seen))
            contacts = max(contacts, int(data.ncon))
    return ReleaseRun(
        _fields(model), _names(model), _options(model), float(model.opt.timestep), every, float(model.stat.extent),
        _stack(states), np.array(bodies), contacts, break_reason(data),
    )  # fmt: skip


def steps_of(request: ModelRun, timestep: float) -> int:
    """Number of steps of a run.

    Raises:
        InvalidInput: they are too many to be kept.
    """
    steps = max(1, round(request.seconds / timestep))
    if steps > MAX_STEPS:
        most = MAX_STEPS * timestep
        raise InvalidInput(
            f"--seconds {request.seconds:g}: these are {steps} steps, at most {MAX_STEPS} are run: {most:g} s"
        )
    return steps


def start_in_words(request: ModelRun) -> str:
    """Describe the start of the model's own run."""
    model, data, keyframe = _start(request)
    return start_words(model, keyframe, data.ctrl)


def advance_states(request: ModelRun, states: Mapping[str, Array], steps: int, perturbed: bool = False) -> Array:
    """Coordinates and rates (T, nq + nv) that each state (T) is advanced to by some steps."""
    model, data, _ = _start(request)
    given, found = _perturb(states) if perturbed else states, list[Array]()
    with silence_warnings():
        for row in range(len(states["time"])):
            mujoco.mj_resetData(model, data)
            _set_state(data, {name: rows[row] for name, rows in given.items()})
            mujoco.mj_step(model, data, steps)
            found.append(np.concatenate([data.qpos, data.qvel]))
    return np.array(found)


def states_between(request: ModelRun, state: Mapping[str, Array], steps: int) -> dict[str, Array]:
    """The states before each of some steps from a state, each part (steps, n)."""
    model, data, _ = _start(request)
    _set_state(data, state)
    found = list[dict[str, Array]]()
    with silence_warnings():
        for _ in range(steps):
            found.append(_state(data))
            mujoco.mj_step(model, data)
    return _stack(found)


def terms_at(request: ModelRun, states: Mapping[str, Array]) -> list[StepTerms]:
    """Terms of the equations of motion at each state, and the state after one step from it."""
    model, data, _ = _start(request)
    found = list[StepTerms]()
    with silence_warnings():
        for row in range(len(states["time"])):
            one = {name: rows[row] for name, rows in states.items()}
            mujoco.mj_resetData(model, data)
            _set_state(data, one)
            mujoco.mj_forward(model, data)
            forces, qacc = {name: np.array(getattr(data, name)) for name in FORCES}, np.array(data.qacc)
            touching = tuple(
                (int(min(c.geom)), int(max(c.geom)), float(c.dist)) for c in (data.contact[k] for k in range(data.ncon))
            )
            # Computing the terms may have changed the solver's first guess.
            _set_state(data, one)
            mujoco.mj_step(model, data)
            found.append(StepTerms(forces, touching, qacc, np.concatenate([data.qpos, data.qvel])))
    return found


# -- timing ------------------------------------------------------------------------------------------------------------

_steppers: list[Block] = []  # of the model that this process steps now


def prepare_model_stepper(request: ModelRun) -> int:
    """Load the model afresh, and prepare to time repetitions of its run; return 0."""
    _steppers.clear()
    model, data, _ = _start(request)
    steps = steps_of(request, float(model.opt.timestep))
    make = looping_stepper(model, state_of(model, data), steps)
    _steppers.append(partial(cpu_time, make(), 1, time.thread_time_ns))
    return 0


def advance_model_stepper(steps: int) -> int:
    """Advance the model by some steps; return the CPU time [ns]."""
    return _steppers[0](steps)


# -- states and fields -------------------------------------------------------------------------------------------------


@lru_cache(maxsize=1)
def _load(path: Path, changed: int) -> mujoco.MjModel:
    """Load a model once for all calls; `changed` is when its file was [ns]."""
    return load_model(path)


def _start(request: ModelRun) -> tuple[mujoco.MjModel, mujoco.MjData, int | None]:
    """Load a model; return it, its data at the start, and the index of its keyframe."""
    path = Path(request.path)
    check_readable(path)
    model = _load(path, path.stat().st_mtime_ns)
    data, keyframe = data_at_start(model, request.keyframe, request.controls)
    return model, data, keyframe


def _state(data: mujoco.MjData) -> dict[str, Array]:
    """Copy the fields of data that a state consists of."""
    return {name: np.array(getattr(data, name), dtype=float) for name in STATE_FIELDS}


def _stack(states: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
    """Stack states by field, each (T, ...)."""
    return {name: np.array([one[name] for one in states]) for name in states[0]}


def _set_state(data: mujoco.MjData, state: Mapping[str, Array]) -> None:
    """Set data to a state."""
    for name, values in state.items():
        if name == "time":
            data.time = float(values)
        else:
            getattr(data, name)[:] = values


def _perturb(states: Mapping[str, Array]) -> dict[str, Array]:
    """States with all coordinates and rates x off by a bit, 2^-52 max(1, |x|)."""
    off = {name: states[name] + 2.0**-52 * np.maximum(1.0, np.abs(states[name])) for name in ("qpos", "qvel")}
    return {**states, **off}


def _positions(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Positions (nbody, 3) of all bodies [m]."""
    mujoco.mj_kinematics(model, data)
    return np.array(data.xpos)


def _fields(model: mujoco.MjModel) -> dict[str, Array]:
    """Physical fields of a model and its options, as numbers by name."""
    names = [
        name for name in dir(model)
        if name.startswith(FIELD_PREFIXES) and not any(part in name for part in NO_PHYSICS)
    ]  # fmt: skip
    found = {name: value for name in names if isinstance(value := getattr(model, name), np.ndarray)}
    known = (name for name in OPTION_FIELDS if hasattr(model.opt, name))
    options = {f"opt.{name}": np.atleast_1d(getattr(model.opt, name)) for name in known}
    return {name: np.array(value, dtype=float) for name, value in {**options, **found}.items()}


def _names(model: mujoco.MjModel) -> dict[str, tuple[str, ...]]:
    """Names of elements by kind, or numbers where they have none; degrees of freedom by their joints."""
    joints = (name_or_number(model, "joint", int(j)) for j in model.dof_jntid)
    found = {
        kind: tuple(name_or_number(model, kind, k) for k in range(count))
        for kind, count in {
            "body": model.nbody, "geom": model.ngeom, "joint": model.njnt, "actuator": model.nu,
            "equality": model.neq, "tendon": model.ntendon,
        }.items()
    }  # fmt: skip
    return {**found, "dof": tuple(joints)}


def _options(model: mujoco.MjModel) -> dict[str, str]:
    """Integrator, solver and kind of Jacobian of a model, in words."""
    jacobian = mujoco.mjtJacobian(int(model.opt.jacobian)).name.removeprefix("mjJAC_")
    sparse = jacobian == "SPARSE" or (jacobian == "AUTO" and model.nv >= SPARSE_FREEDOMS)
    return {
        "integrator": mujoco.mjtIntegrator(int(model.opt.integrator)).name.removeprefix("mjINT_"),
        "solver": mujoco.mjtSolver(int(model.opt.solver)).name.removeprefix("mjSOL_"),
        "dressing": "sparse-jacobian" if sparse else "",
    }
