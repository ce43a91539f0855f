"""Runs in which nothing is driven: MuJoCo's own kinematics at the exact coordinates, and the file as it is."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import warnings_kept_quiet
from conrod.exact.motion import Array
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.exact.space.tree import RATES, SpatialTree, lengths
from conrod.mjcf.loops.driving import advanced, gaps_of, opens, start_state
from conrod.mjcf.loops.results import QUANTITIES, ShippedRun
from conrod.mjcf.runs import STATE, state_of
from conrod.own.models.loading import FoundPoint, listed, name_or_number
from conrod.runs.outcome import OPEN_GAP
from conrod.runs.trajectory import Outcome

# A rate that turns back in this share of all steps, by this share of its range, is the step's, not the machine's.
TURNS_BACK, SWING = 0.6, 1e-3


def kinematic_mode(
    model: mujoco.MjModel, machine: DrivenTree, points: tuple[FoundPoint, ...], motion: SpatialMotion
) -> tuple[dict[str, float], tuple[str, ...]]:
    """Distance of MuJoCo's kinematics from the exact motion, over its largest values; and what is met on the way."""
    off, sizes = dict.fromkeys(QUANTITIES, 0.0), dict.fromkeys(QUANTITIES, 0.0)
    data, opened, touching = mujoco.MjData(model), 0.0, dict[str, None]()
    start = {p.name: motion.points[p.name].position[0] for p in points}
    for k in range(len(motion.times)):
        start_state(data, motion, k)
        with warnings_kept_quiet():
            mujoco.mj_forward(model, data)
        data.qacc[:] = motion.rates[1, :, k]
        mujoco.mj_rnePostConstraint(model, data)
        opened = max([opened, *gaps_of(machine.tree, model, data).values()])
        for contact in data.contact[: data.ncon]:
            if contact.dist < 0.0:
                touching[" and ".join(_part(model, int(g)) for g in contact.geom)] = None
        for point in points:
            exact = motion.points[point.name]
            for name, found in zip(QUANTITIES, point.motion(model, data), strict=True):
                truth = getattr(exact, name)[k]
                size = truth - start[point.name] if name == "position" else truth
                sizes[name] = max(sizes[name], float(np.linalg.norm(size)))
                off[name] = max(off[name], float(np.linalg.norm(found - truth)))
    shares = {name: off[name] / max(sizes[name], 1e-300) for name in QUANTITIES if sizes[name] > 1e-12}
    # Loops that contradict each other stay open; two bodies' rows may each have the misfit.
    shares["closures"] = max(opened - 2.0 * machine.misfit, 0.0) / sizes["position"] if sizes["position"] else 0.0
    return shares, tuple(_met(machine, motion, list(touching)))


def _met(machine: DrivenTree, motion: SpatialMotion, touching: list[str]) -> Iterator[str]:
    if touching:
        yield f"parts touch on the way: {listed(touching)}; the runs have these contacts, the exact motion has none"
    for joint in machine.tree.joints:
        if joint.range is not None and joint.kind in ("hinge", "slide"):
            factor, unit = (np.degrees(1.0), "deg") if joint.unit == "rad" else (1e3, "mm")
            values = motion.coordinates[joint.coordinate]
            over = max(joint.range[0] - values.min(), values.max() - joint.range[1])
            if over > 1e-6:
                limits = f"{factor * joint.range[0]:.4g} to {factor * joint.range[1]:.4g}"
                yield (
                    f"{joint.name} is up to {factor * over:.3g} {unit} beyond its limits, {limits}: "
                    "the runs have these limits, the exact motion has none"
                )


def _part(model: mujoco.MjModel, geom: int) -> str:
    """A geom's name, or its body's."""
    own = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_GEOM, geom)
    return own or name_or_number(model, "body", int(model.geom_bodyid[geom]))


# -- the file as it is ------------------------------------------------------------------------------------------------


def shipped_run(
    tree: SpatialTree, model: mujoco.MjModel, data: mujoco.MjData, seconds: float, start: str, travel: float
) -> ShippedRun:  # fmt: skip
    """The file run as it is, with the controls of its start."""
    steps, aside = max(2, round(seconds / float(model.opt.timestep))), mujoco.MjData(model)
    rates, gaps = list[Array](), dict[str, float]()

    def look(done: int) -> None:
        rates.append(data.qvel.copy())
        if (done - 1) % max(1, steps // 400) == 0:
            mujoco.mj_setState(model, aside, state_of(model, data), STATE)
            mujoco.mj_fwdPosition(model, aside)
            for name, gap in gaps_of(tree, model, aside).items():
                gaps[name] = max(gap, gaps.get(name, 0.0))

    with warnings_kept_quiet():
        reason = advanced(model, data, range(steps), look)
    outcome = Outcome.COMPLETED
    if reason:
        outcome = Outcome.RESET if reason.startswith("MuJoCo reset") else Outcome.DIVERGED
    elif gaps and max(gaps.values()) > OPEN_GAP * max(travel, tree.extent):
        outcome, reason = Outcome.OPENED, opens(gaps)
    chatter = None if reason else _chatter(tree, model, np.array(rates))
    return ShippedRun(start, seconds, outcome, reason, max(gaps.values(), default=0.0), chatter)


def _chatter(tree: SpatialTree, model: mujoco.MjModel, rates: Array) -> tuple[str, float] | None:
    """The joint whose rate turns back at nearly every step of the last half, and its swing over its range."""
    late = rates[len(rates) // 2 :]
    if len(late) < 20:
        return None
    changes = np.diff(late, axis=0)
    back = np.mean(changes[1:] * changes[:-1] < 0.0, axis=0)
    size, ranges = np.median(np.abs(changes), axis=0), np.ptp(rates, axis=0)
    swing = size / np.maximum(ranges, 1e-9)
    # What settles while others move, or rounds, swings in nothing.
    weights = np.concatenate([lengths(tree, joint, RATES) for joint in tree.joints])
    swing[(ranges < 1e-6) | (size * weights < SWING * float(np.max(ranges * weights)))] = 0.0
    worst = int(np.argmax(np.where(back > TURNS_BACK, swing, 0.0)))
    if back[worst] <= TURNS_BACK or swing[worst] <= SWING:
        return None
    return name_or_number(model, "joint", int(model.dof_jntid[worst])), float(swing[worst])
