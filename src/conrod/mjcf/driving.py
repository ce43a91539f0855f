"""A model's run in MuJoCo with its joints driven by laws."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import isfinite

import mujoco
import numpy as np
from numpy.typing import NDArray

from conrod.comparison.other_forces import OtherForce
from conrod.comparison.trajectory import Outcome
from conrod.engines.mujoco import compat
from conrod.engines.mujoco.driven_joints import Drives
from conrod.engines.mujoco.dynamics import bad_number_warnings, silence_warnings
from conrod.engines.mujoco.model import constraint_jacobian
from conrod.exact.motion import Array
from conrod.exact.space import SpatialPoint, SpatialTree
from conrod.exact.space.assembly import RANK_TOLERANCE
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.mjcf.equalities import closure_name, constraint_violations, row_equalities, violation_reader
from conrod.mjcf.force_watch import ForceWatch
from conrod.mjcf.loading import FoundPoint, name_or_number
from conrod.mjcf.point_tracks import point_motions, point_noter

EQUALITY = mujoco.mjtConstraint.mjCNSTR_EQUALITY
INSTANTS_TOGETHER = 128  # at which forces of closures are solved for at once
INTEGRATION = mujoco.mjtState.mjSTATE_INTEGRATION
RESET_REASON = "MuJoCo reset its state"


@dataclass(frozen=True)
class LoopRecording:
    """A run at K samples, all quantities of a sample at one instant.

    Attributes:
        coordinates: coordinates (nq, K) of all joints.
        rates, accelerations: rates and accelerations (nv, K) of all joints.
        points: position, velocity and acceleration (3, K, 3) of each point, by name.
        violations: violation (K,) [m] of each closure, by name.
        drives, reactions: forces of driven joints (K,) and of connects (K, 3), by name; empty if not asked for.
        acting: forces that acted besides weight, inertia and the loops.
    """

    times: Array
    coordinates: Array
    rates: Array
    accelerations: Array
    points: Mapping[str, Array]
    violations: Mapping[str, Array]
    drives: Mapping[str, Array]
    reactions: Mapping[str, Array]
    outcome: Outcome
    reason: str
    acting: tuple[OtherForce, ...] = ()


def set_exact_state(data: mujoco.MjData, motion: SpatialMotion, at: int = 0) -> None:
    """Set data to the exact coordinates and rates of a sample."""
    data.qpos[:], data.qvel[:] = motion.coordinates[:, at], motion.rates[0, :, at]


def driven_run(
    machine: DrivenTree, model: mujoco.MjModel, motion: SpatialMotion, points: tuple[FoundPoint, ...], every: int,
    *, carried: bool = True, touching: tuple[int, int] | None = None,
) -> LoopRecording:  # fmt: skip
    """Run a model with its joints driven through the exact motion's times, a sample each `every` steps.

    Args:
        model: model with the settings and step of the run; a copy of it gets flywheels.
        carried: whether forces are recorded.
        touching: two geoms whose contact is a part of the machine.
    """
    original, model = model, copy.copy(model)
    model.opt.disableflags |= compat.disable_bit("AUTORESET")
    drives, data, plain = Drives(machine, model), mujoco.MjData(model), mujoco.MjData(original)
    set_exact_state(data, motion)
    write = drives.writer(float(model.opt.timestep) * np.arange((len(motion.times) - 1) * every + 1.0))
    rows_of, waiting, found = _cached_closure_rows(model), list[tuple[Array, Array]](), list[tuple[Array, Array]]()
    rows = dict[str, NDArray[np.intp]]()

    def solve_waiting() -> None:
        if waiting:
            closing, needed = (np.array(column) for column in zip(*waiting, strict=True))
            waiting.clear()
            carried, torques = carried_forces(machine, closing, needed)
            places = np.reshape([own[:3] for own in rows.values() if len(own) >= 3], (-1, 3)).astype(int)
            found.append((torques, carried[:, places]))

    def note_forces(aside: mujoco.MjData) -> tuple[()]:
        nonlocal rows
        if (acting := rows_of(aside)) is not rows or len(waiting) == INSTANTS_TOGETHER:
            solve_waiting()
            rows = acting
        waiting.append(needed_forces(original, plain, aside))
        return ()

    with drives.pushing_flywheels():
        run, _ = record_run(
            machine.tree, model, data, points, motion.times, every, lambda done: write(data, done),
            note_forces if carried else lambda _: (), touching,
        )  # fmt: skip
    if not carried:
        return run
    solve_waiting()
    torques, reactions = (np.concatenate(column) for column in zip(*found, strict=True))
    joined = [name for name, own in rows.items() if len(own) >= 3]
    return replace(
        run,
        drives={joint.name: torques[:, k] for k, joint in enumerate(machine.driven)},
        reactions={name: reactions[:, k] for k, name in enumerate(joined)},
    )


def record_run(
    tree: SpatialTree, model: mujoco.MjModel, data: mujoco.MjData, points: tuple[FoundPoint, ...], times: Array,
    every: int = 1, act: Callable[[int], None] = lambda _: None,
    more: Callable[[mujoco.MjData], tuple[Array, ...]] = lambda _: (), touching: tuple[int, int] | None = None,
) -> tuple[LoopRecording, list[Array]]:  # fmt: skip
    """Run a model from a state through times (K,), a sample each `every` steps; return further samples too.

    It ends where MuJoCo warns of numbers that are none. `touching` are geoms whose contact is a part of the machine.
    """
    aside, rows, reason, watch = mujoco.MjData(model), list[tuple[Array, ...]](), "", ForceWatch(model, touching)
    note_points = point_noter(model, points)
    with silence_warnings():
        for k in range(len(times)):
            if k:
                reason = advance(model, data, range((k - 1) * every, k * every), act, watch)
            if reason:
                break
            forward_copy(model, data, aside)
            watch.sample(aside)
            state = aside.qpos.copy(), aside.qvel.copy(), aside.qacc.copy()
            rows.append((*state, note_points(aside), aside.efc_pos[: aside.ne].copy(), *more(aside)))
    equalities = row_equalities(aside)
    acting = list(dict.fromkeys(equalities.tolist()))
    coordinates, rates, accelerations, noted, gaps, *seen = (np.array(column) for column in zip(*rows, strict=True))
    moved = point_motions(model, noted)
    if not reason and not np.all(np.isfinite(moved[-1])):
        reason = f"not finite at {float(data.time):.4g} s"
    opened = violation_reader(model, tree.extent)(equalities, gaps)[:, acting]
    outcome = Outcome.RESET if reason.startswith(RESET_REASON) else Outcome.DIVERGED
    return LoopRecording(
        times[: len(rows)], coordinates.T, rates.T, accelerations.T,
        {point.name: moved[:, k].swapaxes(0, 1) for k, point in enumerate(points)},
        dict(zip((closure_name(model, k) for k in acting), opened.T, strict=True)), {}, {},
        outcome if reason else Outcome.COMPLETED, reason,
        watch.found,
    ), seen  # fmt: skip


def forward_copy(model: mujoco.MjModel, data: mujoco.MjData, aside: mujoco.MjData) -> None:
    """Compute position, velocity and acceleration of the present instant in another data object.

    What `mj_step` leaves of them does not belong together, under RK4 least of all. The run goes on to the last bit as
    if it had not been looked at.
    """
    state = np.empty(mujoco.mj_stateSize(model, INTEGRATION))
    mujoco.mj_getState(model, data, state, INTEGRATION)
    mujoco.mj_setState(model, aside, state, INTEGRATION)
    mujoco.mj_forward(model, aside)
    mujoco.mj_rnePostConstraint(model, aside)


def advance(
    model: mujoco.MjModel, data: mujoco.MjData, steps: range, act: Callable[[int], None], watch: ForceWatch
) -> str:
    """Make some steps, watch forces and act after each; return why the run breaks off, or an empty text."""
    counts, coordinates, rates = data.warning.number, data.qpos, data.qvel
    for k in steps:
        mujoco.mj_step(model, data)
        sound = not any(counts.tolist()) and isfinite(sum(coordinates.tolist()) + sum(rates.tolist()))
        if not sound and (reason := break_off_reason(model, data)):
            return f"{reason} at {(k + 1) * float(model.opt.timestep):.4g} s"
        watch.step(data)
        act(k + 1)
    return ""


def break_off_reason(model: mujoco.MjModel, data: mujoco.MjData) -> str:
    """Why a run's numbers are no longer valid; empty if they are."""
    bad = bad_number_warnings(data)
    # A sum is finite only where its terms are. One that overflows is of numbers that are none any more.
    if not bad and isfinite(sum(data.qpos.tolist()) + sum(data.qvel.tolist())):
        return ""
    reset = bool(bad) and not model.opt.disableflags & compat.disable_bit("AUTORESET")
    return (RESET_REASON if reset else "not finite") + (f" ({', '.join(bad)})" if bad else "")


def closure_rows(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, NDArray[np.intp]]:
    """Constraint rows of each acting closure, by name."""
    rows = np.flatnonzero(data.efc_type[: data.nefc] == EQUALITY)
    ids = data.efc_id[rows]
    return {closure_name(model, int(e)): rows[ids == e] for e in dict.fromkeys(ids.tolist())}


def _cached_closure_rows(model: mujoco.MjModel) -> Callable[[mujoco.MjData], dict[str, NDArray[np.intp]]]:
    """Return `closure_rows` of a model, which looks names up again only where other closures act."""
    last, rows = b"", dict[str, NDArray[np.intp]]()

    def rows_of(data: mujoco.MjData) -> dict[str, NDArray[np.intp]]:
        nonlocal last, rows
        acting = data.efc_id[: data.ne].tobytes()
        if acting != last:
            last, rows = acting, closure_rows(model, data)
        return rows

    return rows_of


def closure_violations(tree: SpatialTree, model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, float]:
    """Violation of each acting closure [m], an angle times the machine's extent."""
    found = constraint_violations(model, data, tree.extent)
    return {closure_name(model, k): float(found[k]) for k in dict.fromkeys(row_equalities(data).tolist())}


def widest_opening_words(gaps: Mapping[str, float]) -> str:
    """Describe the closure with the largest opening."""
    worst = max(gaps, key=lambda name: gaps[name])
    return f"{worst} opens by {1e3 * gaps[worst]:.3g} mm"


def needed_forces(original: mujoco.MjModel, plain: mujoco.MjData, data: mujoco.MjData) -> tuple[Array, Array]:
    """Return the closures' Jacobian (ne, nv), and the joint forces (nv,) that they and the drives make.

    All joints keep M a + bias = passive + actuator + J' f + drive (MuJoCo documentation, Computation).

    Args:
        original: the model without flywheels, and `plain` its data.
    """
    plain.qpos[:], plain.qvel[:] = data.qpos, data.qvel
    mujoco.mj_fwdPosition(original, plain)
    needed = np.empty(original.nv)
    mujoco.mj_mulM(original, plain, needed, np.array(data.qacc))
    needed += data.qfrc_bias - data.qfrc_passive - data.qfrc_actuator
    jacobian, equalities = constraint_jacobian(original, data), data.ne
    if data.nefc > equalities:
        needed -= jacobian[equalities:].T @ data.efc_force[equalities:]
    return jacobian[:equalities], needed


def carried_forces(machine: DrivenTree, closing: Array, needed: Array) -> tuple[Array, Array]:
    """Forces of the closures (T, ne) and of the drives (T, n), from `needed_forces` at T samples.

    Those joints that are not driven give the closures' forces, of which hardened closures have lost digits in MuJoCo's
    own forces.
    """
    transposed = np.swapaxes(closing[:, :, machine.free], 1, 2)
    carried = _shortest_solutions(transposed, needed[:, machine.free])
    needed = needed - (np.swapaxes(closing, 1, 2) @ carried[:, :, None])[:, :, 0]
    return carried, needed[:, [joint.rate for joint in machine.driven]]


def _shortest_solutions(matrices: Array, right: Array) -> Array:
    """Shortest x (T, n) with the least |A x - b|, of matrices A (T, m, n) and b (T, m); small singular values are 0."""
    samples, height, width = matrices.shape
    if height == width:
        # In the 1-norm |A| |1/A| is at least 1 / n of the ratio of the singular values: below the limit none is 0.
        try:
            inverse = np.linalg.inv(matrices)
            sizes = np.abs(matrices).sum(axis=1).max(axis=1) * np.abs(inverse).sum(axis=1).max(axis=1)
            if np.all(sizes * width * RANK_TOLERANCE < 1.0):
                return np.asarray(np.linalg.solve(matrices, right[:, :, None])[:, :, 0])
        except np.linalg.LinAlgError:
            pass
    solved = [np.linalg.lstsq(one, b, rcond=RANK_TOLERANCE)[0] for one, b in zip(matrices, right, strict=True)]
    return np.reshape(solved, (samples, width))


def site_points(
    model: mujoco.MjModel, names: tuple[str, ...], others: Mapping[str, SpatialPoint] | None = None
) -> tuple[FoundPoint, ...]:
    """Points by name: sites, or frames of bodies where no site has the name, or others where neither has it."""
    kinds = {"body": range(model.nbody), "site": model.site_bodyid.tolist()}
    found = {
        name_or_number(model, kind, k): FoundPoint(name_or_number(model, kind, k), kind, k, body)
        for kind, bodies in kinds.items()
        for k, body in enumerate(bodies)
    }
    return tuple(found.get(name) or _body_point(name, (others or {})[name]) for name in names)


def _body_point(name: str, point: SpatialPoint) -> FoundPoint:
    """A point of a body, at an offset from the body's frame."""
    x, y, z = point.offset.tolist()
    return FoundPoint(name, "body", point.body, point.body, (x, y, z))
