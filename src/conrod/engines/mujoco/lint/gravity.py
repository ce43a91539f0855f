"""Gravity across the plane in which everything moves."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.engines.mujoco.lint.bench import Bench
from conrod.engines.mujoco.lint.edits import Edit, SetOption
from conrod.engines.mujoco.lint.finding import Finding, Harm, Note
from conrod.engines.mujoco.lint.rule import Rule
from conrod.motion import Array

# Motion out of a plane below this share of that in it is what soft closures sag by.
PLANAR = 1e-2
# Of gravity. A machine that is a hundredth of a degree out of the vertical has 2e-4; rounding of a vector written with
# six digits, 1e-6.
ACROSS = 1e-5
SAME_MOTION = 1e-6  # of the travel: what the closures sag by must not be taken for motion


def judge(bench: Bench) -> Iterator[Finding | Note]:
    """The part of gravity along the normal of the plane: does the motion know of it?"""
    model = bench.model
    if int(model.opt.disableflags) & mujoco.mjtDisableBit.mjDSBL_GRAVITY:
        return
    gravity = np.array(model.opt.gravity)
    normal = plane_normal(bench)
    if normal is None or abs(gravity @ normal) <= ACROSS * np.linalg.norm(gravity):
        return
    across = float(abs(gravity @ normal))
    if bench.run.touched:
        yield Note(RULE.name, f"gravity has {across:.4g} m/s² across the plane of motion, where contacts carry it")
        return
    rest = gravity - (gravity @ normal) * normal
    rest[np.abs(rest) < ACROSS * np.linalg.norm(gravity)] = 0.0
    edits: tuple[Edit, ...] = (SetOption(("option",), "gravity", " ".join(f"{value:.9g}" for value in rest)),)
    change = bench.change(edits)
    moving = model.body_weldid > 0
    yield Finding(
        rule=RULE.name,
        subjects=(),
        what=f"gravity has {across:.4g} m/s² across the plane in which everything moves",
        harm=Harm.WRONG if change > SAME_MOTION else Harm.LATENT,
        evidence=(
            ("normal of the plane", " ".join(f"{value:.6g}" for value in np.where(np.abs(normal) < 1e-9, 0.0, normal))),
            ("share of gravity", across / float(np.linalg.norm(gravity))),
            ("weight that joints carry across [N]", across * float(model.body_mass[moving].sum())),
            ("change of motion without", change),
        ),
        why="it does no work on the motion: joints and closures carry it, reactions contain it, soft closures sag by "
        "it; a machine that stands upright has its gravity in the plane",
        fix="turn the machine, or the gravity, into the plane; or leave that part of it out",
        edits=edits,
        safe=change <= SAME_MOTION,
        change=change,
    )


def plane_normal(bench: Bench) -> Array | None:
    """Normal of the plane that all bodies stay parallel to in the run; None where there is none, or it is not told."""
    turning, moving = _velocities(bench)
    _, spins, axes = np.linalg.svd(turning, full_matrices=False)
    if not spins[0] > 0.0 or spins[1] > PLANAR * spins[0]:
        return None
    normal: Array = axes[0]
    speeds = np.linalg.norm(moving, axis=1).max()
    return normal if np.abs(moving @ normal).max() <= PLANAR * speeds else None


def _velocities(bench: Bench) -> tuple[Array, Array]:
    """Angular velocities and those of the centres of gravity, (n, 3) each, of all bodies at all looks."""
    turning, moving = [np.zeros(3)] * 3, [np.zeros(3)]
    for data in bench.poses.each():
        for body in np.flatnonzero(bench.model.body_weldid > 0):
            velocity = np.empty(6)
            mujoco.mj_objectVelocity(bench.model, data, mujoco.mjtObj.mjOBJ_BODY, int(body), velocity, 0)
            turning.append(velocity[:3].copy())
            moving.append(velocity[3:].copy())
    return np.array(turning), np.array(moving)


RULE = Rule("gravity-across", judge)
