"""Rules on masses and gravity: gravity across the plane of motion, and inertias that the compiler has changed."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.exact.motion import Array
from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.edits import Edit, SetOption
from conrod.mjcf.lint.findings import Finding, Harm, Note, Value
from conrod.own.models.loading import listed, name_or_number

# Motion out of a plane below this share of that in it is what soft closures sag by.
PLANAR = 1e-2
# Of gravity. A machine that is a hundredth of a degree out of the vertical has 2e-4; rounding of a vector written with
# six digits, 1e-6.
ACROSS = 1e-5
SAME_MOTION_WITHOUT_GRAVITY = 1e-6  # of the travel: what the closures sag by must not be taken for motion


def gravity_across(bench: Bench) -> Iterator[Finding | Note]:
    """The part of gravity along the normal of the plane, and whether the motion depends on it."""
    model = bench.model
    if int(model.opt.disableflags) & mujoco.mjtDisableBit.mjDSBL_GRAVITY:
        return
    gravity = np.array(model.opt.gravity)
    normal = plane_normal(bench)
    if normal is None or abs(gravity @ normal) <= ACROSS * np.linalg.norm(gravity):
        return
    across = float(abs(gravity @ normal))
    if bench.run.touched:
        yield Note(f"gravity has {across:.4g} m/s² across the plane of motion, where contacts carry it")
        return
    rest = gravity - (gravity @ normal) * normal
    rest[np.abs(rest) < ACROSS * np.linalg.norm(gravity)] = 0.0
    edits: tuple[Edit, ...] = (SetOption(("option",), "gravity", " ".join(f"{value:.9g}" for value in rest)),)
    change = bench.change(edits)
    moving = model.body_weldid > 0
    yield Finding(
        subjects=(),
        what=f"gravity has {across:.4g} m/s² across the plane in which everything moves",
        harm=Harm.WRONG if change > SAME_MOTION_WITHOUT_GRAVITY else Harm.LATENT,
        evidence={
            "normal of the plane": " ".join(f"{value:.6g}" for value in np.where(np.abs(normal) < 1e-9, 0.0, normal)),
            "share of gravity": across / float(np.linalg.norm(gravity)),
            "weight that joints carry across [N]": across * float(model.body_mass[moving].sum()),
            "change of motion without": change,
        },
        fix="turn the machine, or the gravity, into the plane; or leave that part of it out",
        edits=edits,
        safe=change <= SAME_MOTION_WITHOUT_GRAVITY,
        change=change,
    )


def plane_normal(bench: Bench) -> Array | None:
    """Normal of the plane that all bodies stay parallel to in the run; None where there is none, or nothing turns."""
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


SAME_MOTION = 1e-6  # of the travel: the motion of a driven machine knows of masses only by what is soft in it
# Everything by which the compiler changes what is written, turned off.
AS_WRITTEN = (
    SetOption(("compiler",), "balanceinertia", "false"),
    SetOption(("compiler",), "boundmass", "0"),
    SetOption(("compiler",), "boundinertia", "0"),
    SetOption(("compiler",), "settotalmass", "-1"),
    SetOption(("compiler",), "inertiafromgeom", "auto"),
)
SAME = 1e-9  # the sums are the same, their order may not be


def changed_inertias(bench: Bench) -> Iterator[Finding]:
    """The model compiled a second time, with what is written taken at its word."""
    model = bench.model
    try:
        written = bench.copy(AS_WRITTEN)
    except ValueError as error:
        yield _finding((), {"compiled as written": " ".join(str(error).split())}, None)
        return
    masses = ~np.isclose(model.body_mass, written.body_mass, rtol=SAME, atol=0.0)
    # Principal moments come in an order of their own.
    compiled, meant = (np.sort(one.body_inertia, axis=1) for one in (model, written))
    inertias = ~np.isclose(compiled, meant, rtol=SAME, atol=0.0).all(axis=1)
    changed = np.flatnonzero(masses | inertias)
    if not len(changed):
        return
    names = tuple(name_or_number(model, "body", int(body)) for body in changed)
    worst = int(max(changed, key=lambda body: _ratio(model.body_mass[body], written.body_mass[body])))
    evidence: dict[str, Value] = {
        "bodies changed": len(changed),
        "most changed": name_or_number(model, "body", worst),
        "its mass as written [kg]": float(written.body_mass[worst]),
        "its mass as compiled [kg]": float(model.body_mass[worst]),
        "its moments as written [kg m²]": _moments(written.body_inertia[worst]),
        "its moments as compiled [kg m²]": _moments(model.body_inertia[worst]),
    }
    yield _finding(names, evidence, bench.change(AS_WRITTEN) if not bench.run.broke else None)


def _finding(names: tuple[str, ...], evidence: dict[str, Value], change: float | None) -> Finding:
    what = "the compiler makes masses or inertias up, without which the model does not compile"
    if names:
        what = f"masses or inertias of {listed(names)} are not those that are written"
    return Finding(
        subjects=names,
        what=what,
        harm=Harm.LATENT if change is not None and change <= SAME_MOTION else Harm.WRONG,
        evidence=evidence if change is None else {**evidence, "change of motion as written": change},
        fix="write every mass and inertia as it is, and take balanceinertia, boundmass, boundinertia, settotalmass and "
        "inertiafromgeom out of <compiler>",
        edits=AS_WRITTEN if names else (),
        change=change,
    )


def _ratio(one: float, other: float) -> float:
    least = max(min(one, other), 1e-300)
    return float(max(one, other) / least)


def _moments(values: Array) -> str:
    return " ".join(f"{value:.6g}" for value in np.sort(values))
