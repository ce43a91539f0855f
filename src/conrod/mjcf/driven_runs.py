"""A model against its exact motion: its kinematics, its driven runs with their settings, and the file as it is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import mujoco
import numpy as np

from conrod.comparison.outcome import MAX_JOINT_GAP
from conrod.comparison.trajectory import Outcome
from conrod.engines.mujoco.driven_joints import model_with_settings, preset_settings
from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.errors import InvalidInput, list_names
from conrod.exact.motion import Array
from conrod.exact.space import RATES, SpatialTree, unit_displacements
from conrod.exact.space.forward_kinematics import forward_kinematics
from conrod.exact.space.mobility import SpatialForces
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.mjcf.driving import (
    RESET_REASON,
    LoopRecording,
    advance,
    closure_violations,
    set_exact_state,
    widest_opening_words,
)
from conrod.mjcf.equalities import closure_name, row_equalities, violation_reader
from conrod.mjcf.force_watch import ForceWatch, geom_name
from conrod.mjcf.loading import FoundPoint, name_or_number
from conrod.mjcf.loop_results import LOOP_UNITS, OWN_SETTINGS, LoopRun, ShippedRun
from conrod.mjcf.runs import STATE, state_of

# A force below this share of the largest is none: balanced, or across what the machine does.
NO_FORCE = 1e-9
# A rate that turns back in this share of all steps, by this share of its range, is the step's, not the machine's.
CHATTER_SHARE, CHATTER_SWING = 0.6, 1e-3
LIMIT_ROUNDING = 1e-6  # of a limit, that a motion may be and is rounding [rad, m]


# -- driven runs ------------------------------------------------------------------------------------------------------


def with_settings(
    model: mujoco.MjModel, label: str, step: float, period: float, *, idle: bool = False, contact: bool = False
) -> mujoco.MjModel:
    """Copy a model with the file's or a preset's settings, a step [s], and a converging solver.

    Args:
        idle, contact: as in `preset_settings`.
    """
    settings = None if label == OWN_SETTINGS else preset_settings(label, step, period, idle, contact)
    return model_with_settings(model, step, settings)


def judge_run(
    label: str, step: float, run: LoopRecording, motion: SpatialMotion, machine: DrivenTree,
    exact: SpatialForces | None, travel: float,
) -> LoopRun:  # fmt: skip
    """Compare a run with the exact motion at the same times.

    Args:
        label: name of the settings.
        step: of the run [s].
        exact: forces along the exact motion; None if forces are not compared.
        travel: largest distance [m] that a judged point moves from its start.
    """
    gaps = {name: float(np.nanmax(gap)) for name, gap in run.violations.items()}
    gap = max(gaps.values(), default=0.0)
    if run.outcome is not Outcome.COMPLETED:
        return LoopRun(label, step, run.outcome, run.reason, gap=gap)
    if gap > MAX_JOINT_GAP * travel:
        return LoopRun(label, step, Outcome.OPENED, widest_opening_words(gaps), gap=gap)
    off = {
        name: np.linalg.norm(found - np.array([getattr(motion.points[name], q) for q in LOOP_UNITS]), axis=2)
        for name, found in run.points.items()
    }
    errors = {q: max(float(one[k].max()) for one in off.values()) for k, q in enumerate(LOOP_UNITS)}
    worst = max(off, key=lambda name: float(off[name][0].max()))
    far, near = int(off[worst][0].argmax()), MAX_JOINT_GAP * travel
    here, there = (found[:, far : far + 1] for found in (run.coordinates, motion.coordinates))
    time = float(run.times[far])
    if errors["position"] > near and is_on_other_branch(machine, run.points, here, time, there, near):
        return LoopRun(label, step, Outcome.FLIPPED, f"on another branch {machine.describe_drives(time)}", gap=gap)
    drives, reactions = dict[str, float](), dict[str, float]()
    if exact is not None:
        drives = _relative(run.drives, exact.drives)
        reactions = _relative(run.reactions, exact.reactions)
    return LoopRun(label, step, Outcome.COMPLETED, "", errors, worst, gap, drives, reactions)


def is_on_other_branch(
    machine: DrivenTree, names: Iterable[str], coordinates: Array, time: float, exact: Array, near: float
) -> bool:
    """True if the closed pose nearest to coordinates (nq, 1) is not the exact one (nq, 1).

    Args:
        names: points that drives determine; on one branch they are no further apart than `near`.
    """
    try:
        nearest = machine.close_loops(coordinates, time)[0]
    except InvalidInput:
        return False
    there = forward_kinematics(machine.tree, np.concatenate([nearest, exact], axis=1))
    places = [there.point(machine.tree.points[name])[0] for name in names]
    return max(float(np.linalg.norm(place[:, 0] - place[:, 1])) for place in places) > near


def _relative(found: Mapping[str, Array], exact: Mapping[str, Array]) -> dict[str, float]:
    """Largest deviation of each force over its largest exact value, without wholly unknown forces."""
    known = {name: truth for name, truth in exact.items() if not np.all(np.isnan(truth))}
    sizes = {name: float(np.nanmax(np.abs(truth))) for name, truth in known.items()}
    least = max(NO_FORCE * max(sizes.values(), default=0.0), 1e-300)
    return {
        name: float(np.nanmax(np.abs(found[name] - truth))) / max(sizes[name], least) for name, truth in known.items()
    }


# -- kinematic mode ---------------------------------------------------------------------------------------------------


def compare_kinematics(
    model: mujoco.MjModel, machine: DrivenTree, points: tuple[FoundPoint, ...], motion: SpatialMotion
) -> tuple[dict[str, float], tuple[str, ...]]:
    """Largest relative deviations of MuJoCo's kinematics, and remarks on limits and contacts."""
    off, sizes = dict.fromkeys(LOOP_UNITS, 0.0), dict.fromkeys(LOOP_UNITS, 0.0)
    data, opened, touching = mujoco.MjData(model), 0.0, dict[str, None]()
    start, lengths = {p.name: motion.points[p.name].position[0] for p in points}, list[Array]()
    for k in range(len(motion.times)):
        set_exact_state(data, motion, k)
        with silence_warnings():
            mujoco.mj_forward(model, data)
        data.qacc[:] = motion.rates[1, :, k]
        mujoco.mj_rnePostConstraint(model, data)
        lengths.append(data.ten_length.copy())
        opened = max([opened, *closure_violations(machine.tree, model, data).values()])
        for contact in data.contact[: data.ncon]:
            if contact.dist < 0.0:
                touching[" and ".join(sorted(geom_name(model, int(g)) for g in contact.geom))] = None
        for point in points:
            exact = motion.points[point.name]
            for name, found in zip(LOOP_UNITS, point.motion(model, data), strict=True):
                truth = getattr(exact, name)[k]
                size = truth - start[point.name] if name == "position" else truth
                sizes[name] = max(sizes[name], float(np.linalg.norm(size)))
                off[name] = max(off[name], float(np.linalg.norm(found - truth)))
    shares = {name: off[name] / max(sizes[name], 1e-300) for name in LOOP_UNITS if sizes[name] > 1e-12}
    # Loops that contradict each other stay open; two bodies' rows may each have the misfit.
    shares["closures"] = max(opened - 2.0 * machine.misfit, 0.0) / sizes["position"] if sizes["position"] else 0.0
    met = (*_limit_remarks(machine, motion, list(touching)), *_tendon_remarks(model, np.array(lengths)))
    return shares, met


def tendons_beyond_limits(model: mujoco.MjModel, lengths: Array) -> Iterator[tuple[str, Array, tuple[float, float]]]:
    """Tendons whose lengths (K, ntendon) exceed their limits, with their lengths and limits."""
    if model.opt.disableflags & (mujoco.mjtDisableBit.mjDSBL_LIMIT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT):
        return
    for k in np.flatnonzero(model.tendon_limited).tolist():
        (low, high), length = model.tendon_range[k].tolist(), lengths[:, k]
        if length.min() < low - LIMIT_ROUNDING or length.max() > high + LIMIT_ROUNDING:
            yield name_or_number(model, "tendon", k), length, (low, high)


def _tendon_remarks(model: mujoco.MjModel, lengths: Array) -> Iterator[str]:
    for name, length, (low, high) in tendons_beyond_limits(model, lengths):
        over = max(low - length.min(), length.max() - high)
        yield (
            f"the length of tendon {name} is up to {over:.3g} beyond its limits, {low:.4g} to {high:.4g}: "
            "the runs have these limits, the exact motion has none"
        )


def _limit_remarks(machine: DrivenTree, motion: SpatialMotion, touching: list[str]) -> Iterator[str]:
    if touching:
        yield f"parts touch on the way: {list_names(touching)}; the runs have these contacts, the exact motion has none"
    for joint in machine.tree.joints:
        if joint.range is not None and joint.kind in ("hinge", "slide"):
            factor, unit = (np.degrees(1.0), "deg") if joint.unit == "rad" else (1e3, "mm")
            values = motion.coordinates[joint.coordinate]
            over = max(joint.range[0] - values.min(), values.max() - joint.range[1])
            if over > LIMIT_ROUNDING:
                limits = f"{factor * joint.range[0]:.4g} to {factor * joint.range[1]:.4g}"
                yield (
                    f"{joint.name} is up to {factor * over:.3g} {unit} beyond its limits, {limits}: "
                    "the runs have these limits, the exact motion has none"
                )


# -- the file as it is ------------------------------------------------------------------------------------------------


def shipped_run(
    tree: SpatialTree, model: mujoco.MjModel, data: mujoco.MjData, seconds: float, start: str, travel: float
) -> ShippedRun:  # fmt: skip
    """Run the file as it is, with the controls of its start."""
    steps, aside = max(2, round(seconds / float(model.opt.timestep))), mujoco.MjData(model)
    driven = bool(np.any(data.ctrl) or np.any(data.qvel))
    rates, gaps, watch, places = list[Array](), dict[int, float](), ForceWatch(model), list[Array]()
    read_violations = violation_reader(model, tree.extent)

    def record(done: int) -> None:
        rates.append(data.qvel.copy())
        if (done - 1) % max(1, steps // 400) == 0:
            watch.sample(data)
            mujoco.mj_setState(model, aside, state_of(model, data), STATE)
            mujoco.mj_fwdPosition(model, aside)
            places.append(aside.xpos.copy())
            equalities = row_equalities(aside)
            found = read_violations(equalities, aside.efc_pos[: aside.ne]).tolist()
            for k in dict.fromkeys(equalities.tolist()):
                gaps[k] = max(found[k], gaps.get(k, 0.0))

    with silence_warnings():
        reason = advance(model, data, range(steps), record, watch)
    outcome = Outcome.COMPLETED
    if reason:
        outcome = Outcome.RESET if reason.startswith(RESET_REASON) else Outcome.DIVERGED
    elif gaps and max(gaps.values()) > MAX_JOINT_GAP * max(travel, tree.extent):
        outcome, reason = Outcome.OPENED, widest_opening_words({closure_name(model, k): gap for k, gap in gaps.items()})
    chatter = None if reason else _chatter(tree, model, np.array(rates))
    paths = np.linalg.norm(np.diff(places, axis=0), axis=2).sum(axis=0) if len(places) > 1 else np.zeros(1)
    return ShippedRun(
        start, seconds, outcome, reason, max(gaps.values(), default=0.0), chatter, driven, watch.found,
        path=float(paths.max()),
    )  # fmt: skip


def _chatter(tree: SpatialTree, model: mujoco.MjModel, rates: Array) -> tuple[str, float] | None:
    """The joint whose rate reverses at nearly every step of the last half, and its swing over its range."""
    late = rates[len(rates) // 2 :]
    if len(late) < 20:
        return None
    changes = np.diff(late, axis=0)
    back = np.mean(changes[1:] * changes[:-1] < 0.0, axis=0)
    size, ranges = np.median(np.abs(changes), axis=0), np.ptp(rates, axis=0)
    swing = size / np.maximum(ranges, 1e-9)
    # What settles while others move, or rounds, swings in nothing.
    weights = np.concatenate([unit_displacements(tree, joint, RATES) for joint in tree.joints])
    swing[(ranges < 1e-6) | (size * weights < CHATTER_SWING * float(np.max(ranges * weights)))] = 0.0
    worst = int(np.argmax(np.where(back > CHATTER_SHARE, swing, 0.0)))
    if back[worst] <= CHATTER_SHARE or swing[worst] <= CHATTER_SWING:
        return None
    return name_or_number(model, "joint", int(model.dof_jntid[worst])), float(swing[worst])
