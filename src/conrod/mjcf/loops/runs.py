"""Settings of a model's runs, and their errors against the exact motion."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.mujoco.settings import HARDENING, MuJoCoSettings
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space.forces import SpatialForces
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.exact.space.poses import poses
from conrod.mjcf.loops.driving import Recording, opens
from conrod.mjcf.loops.results import OWN, QUANTITIES, LoopRun
from conrod.own.models.driving import changed
from conrod.runs.outcome import OPEN_GAP
from conrod.runs.trajectory import Outcome

# Hardening of a machine with an idle spin: an RSSR linkage whose rod has 1/500 of its inertia about itself is off by
# 1 mm at 1e-9 and by 1e-7 mm at 1e-7 (1 m, 1 ms).
SOFTER = 1e-7
# Solver tolerance: at 0 Newton's method goes on where nothing is gained any more, to its last iteration in most steps
# (of Agility's Cassie 100 in place of 2, at 12 times the cost).
CONVERGED = 1e-30
# A force below this share of the largest is none: balanced, or across what the machine does.
NO_FORCE = 1e-9


def with_settings(model: mujoco.MjModel, label: str, step: float, period: float, idle: bool) -> mujoco.MjModel:
    """A copy with a preset's settings, or its own, at a step [s]; the solver goes on to the end, as flywheels need.

    Args:
        idle: whether the drives leave a freedom, whose inertia rounding hides beside closures that are too hard.
    """
    own = copy.copy(model)
    own.opt.timestep = step
    if label == OWN:
        return changed(own, tolerance=CONVERGED)
    return changed(own, _settings(label, step, period, idle), CONVERGED)


def pasted(label: str, step: float, period: float, idle: bool) -> str:
    """Edits that a model needs to run with such settings: MJCF, and what MJCF cannot say."""
    if label == OWN:
        return f'<option timestep="{step:.6g}"/>'
    settings = _settings(label, step, period, idle)
    solref, solimp = (" ".join(f"{value:.6g}" for value in pair) for pair in (settings.solref, settings.solimp))
    option = (
        f'<option timestep="{step:.6g}" integrator="{settings.integrator}" solver="Newton" tolerance="{CONVERGED:g}"/>'
    )
    closures = f'<default><equality solref="{solref}" solimp="{solimp}"/></default>'
    hardened = (
        "" if settings.hardening is None else f"\nconrod.harden(model, {settings.hardening:g})  # after compiling"
    )
    return f"{option}\n{closures}{hardened}"


def _settings(label: str, step: float, period: float, idle: bool) -> MuJoCoSettings:
    tuned = MuJoCoSettings("stock", 2, step).as_tuned(contact=False)
    if label != "hardened":
        return tuned
    return replace(
        tuned, preset=label, solref=(max(0.1 * period, tuned.solref[0]), 1.0), hardening=SOFTER if idle else HARDENING
    )


def errors_of(
    label: str, step: float, run: Recording, motion: SpatialMotion, machine: DrivenTree, exact: SpatialForces | None,
    travel: float,
) -> LoopRun:  # fmt: skip
    """A run with its errors against the exact motion at the same times."""
    gaps = {name: float(np.nanmax(gap)) for name, gap in run.gaps.items()}
    gap = max(gaps.values(), default=0.0)
    if run.outcome is not Outcome.COMPLETED:
        return LoopRun(label, step, run.outcome, run.reason, gap=gap)
    if gap > OPEN_GAP * travel:
        return LoopRun(label, step, Outcome.OPENED, opens(gaps), gap=gap)
    off = {
        name: np.linalg.norm(found - np.array([getattr(motion.points[name], q) for q in QUANTITIES]), axis=2)
        for name, found in run.points.items()
    }
    errors = {q: max(float(one[k].max()) for one in off.values()) for k, q in enumerate(QUANTITIES)}
    worst = max(off, key=lambda name: float(off[name][0].max()))
    far = int(off[worst][0].argmax()) if errors["position"] > OPEN_GAP * travel else None
    if far is not None and (where := _flipped(run, far, machine, motion, travel)):
        return LoopRun(label, step, Outcome.FLIPPED, where, gap=gap)
    drives, reactions = dict[str, float](), dict[str, float]()
    if exact is not None:
        drives = _relative(run.drives, exact.drives)
        reactions = _relative(run.reactions, exact.reactions)
    return LoopRun(label, step, Outcome.COMPLETED, "", errors, worst, gap, drives, reactions)


def _flipped(run: Recording, sample: int, machine: DrivenTree, motion: SpatialMotion, travel: float) -> str:
    """Reason for a run on another branch, whose nearest closed pose is not the exact one; empty where it is."""
    time = float(run.times[sample])
    try:
        nearest = machine.closed(run.coordinates[:, sample : sample + 1], time)[0]
    except InvalidInput:
        return ""
    there = poses(machine.tree, nearest)
    apart = [
        float(np.linalg.norm(there.point(machine.tree.points[name])[0][:, 0] - motion.points[name].position[sample]))
        for name in run.points
    ]
    return f"on another branch {machine.where(time)}" if max(apart) > OPEN_GAP * travel else ""


def _relative(found: Mapping[str, Array], exact: Mapping[str, Array]) -> dict[str, float]:
    """Largest deviations over the largest exact value each, or what rounding leaves of the largest of all.

    Those are left out of which nothing is known.
    """
    known = {name: truth for name, truth in exact.items() if not np.all(np.isnan(truth))}
    sizes = {name: float(np.nanmax(np.abs(truth))) for name, truth in known.items()}
    least = max(NO_FORCE * max(sizes.values(), default=0.0), 1e-300)
    return {
        name: float(np.nanmax(np.abs(found[name] - truth))) / max(sizes[name], least) for name, truth in known.items()
    }
