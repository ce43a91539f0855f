"""Rules on masses: gravity across the plane, inertias made by the compiler."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.exact.motion import Array
from conrod.mjcf.lint.bench import Bench, rule
from conrod.mjcf.lint.findings import Finding, Harm, Note, SetOption
from conrod.mjcf.runs import velocity
from conrod.own.models.loading import listed, name_or_number

# -- gravity ---------------------------------------------------------------------------------------------------------

# Motion out of a plane below this share of that in it is what soft closures sag by.
PLANAR = 1e-2
# Of gravity. A machine that is a hundredth of a degree out of the vertical has 2e-4; rounding of a vector written with
# six digits, 1e-6.
ACROSS = 1e-5
# Of the travel: what closures sag by must not be taken for motion, and the motion of a driven machine knows of masses
# only by what is soft in it.
SAME_MOTION = 1e-6


@rule(
    "it does no work on the motion: joints and closures carry it, reactions contain it, soft closures sag by it; a "
    "machine that stands upright has its gravity in the plane",
)
def gravity_across(bench: Bench) -> Iterator[Finding | Note]:
    """Gravity across the plane in which everything moves."""
    model, gravity, normal = bench.model, np.array(bench.model.opt.gravity), plane_normal(bench)
    least = ACROSS * np.linalg.norm(gravity)
    if int(model.opt.disableflags) & mujoco.mjtDisableBit.mjDSBL_GRAVITY or normal is None:
        return
    across = float(abs(gravity @ normal))
    if across <= least:
        return
    if bench.run.touched:
        yield Note(f"gravity has {across:.4g} m/s² across the plane of motion, where contacts carry it")
        return
    rest = gravity - (gravity @ normal) * normal
    rest[np.abs(rest) < least] = 0.0
    edits = (SetOption(("option",), "gravity", " ".join(f"{value:.9g}" for value in rest)),)
    change = bench.change(edits)
    yield Finding(
        what=f"gravity has {across:.4g} m/s² across the plane in which everything moves",
        harm=Harm.WRONG if change > SAME_MOTION else Harm.LATENT,
        evidence={
            "normal of the plane": _digits(np.where(np.abs(normal) < 1e-9, 0.0, normal)),
            "share of gravity": across / float(np.linalg.norm(gravity)),
            "weight that joints carry across [N]": across * float(model.body_mass[model.body_weldid > 0].sum()),
            "change of motion without": change,
        },
        fix="turn the machine, or the gravity, into the plane; or leave that part of it out",
        # Never safe: loads and free motion would be those of another machine, whatever this motion shows.
        edits=edits,
        change=change,
    )


def plane_normal(bench: Bench) -> Array | None:
    """Normal of the plane that all bodies stay parallel to in the run; None where there is none, or nothing turns."""
    bodies = np.flatnonzero(bench.model.body_weldid > 0).tolist()
    found = [velocity(bench.model, data, body) for data in bench.poses() for body in bodies]
    # With three that do not move, so that there are three singular values.
    turning, moving = np.split(np.vstack([np.zeros((3, 6)), *found]), 2, axis=1)
    _, spins, axes = np.linalg.svd(turning, full_matrices=False)
    if not spins[0] > 0.0 or spins[1] > PLANAR * spins[0]:
        return None
    normal: Array = axes[0]
    return normal if np.abs(moving @ normal).max() <= PLANAR * np.linalg.norm(moving, axis=1).max() else None


# -- inertias --------------------------------------------------------------------------------------------------------

# Everything by which the compiler changes what is written, turned off.
NOT_WRITTEN = {"balanceinertia": "false", "boundmass": "0", "boundinertia": "0", "settotalmass": "-1"}
AS_WRITTEN = tuple(
    SetOption(("compiler",), name, value) for name, value in {**NOT_WRITTEN, "inertiafromgeom": "auto"}.items()
)
SAME = 1e-9  # the sums are the same, their order may not be
WRITE = (
    "write every mass and inertia as it is, and take balanceinertia, boundmass, boundinertia, settotalmass and "
    "inertiafromgeom out of <compiler>"
)


@rule("drive torques, reactions and free motion are those of another machine", needs_motion=False)
def changed_inertia(bench: Bench) -> Iterator[Finding]:
    """Masses or inertias that the compiler made others than those written."""
    model = bench.model
    try:
        written = bench.edited(AS_WRITTEN).model
    except ValueError as error:
        yield Finding(
            what="the compiler makes masses or inertias up, without which the model does not compile",
            harm=Harm.WRONG,
            evidence={"compiled as written": " ".join(str(error).split())},
            fix=WRITE,
        )
        return
    # Principal moments come in an order of their own.
    compiled, meant = (np.column_stack([m.body_mass, np.sort(m.body_inertia, axis=1)]) for m in (model, written))
    changed = np.flatnonzero(~np.isclose(compiled, meant, rtol=SAME, atol=0.0).all(axis=1)).tolist()
    if not changed:
        return
    names = tuple(name_or_number(model, "body", body) for body in changed)
    change = None if bench.run.broke else bench.change(AS_WRITTEN)
    yield Finding(
        subjects=names,
        what=f"masses or inertias of {listed(names)} are not those that are written",
        harm=Harm.LATENT if change is not None and change <= SAME_MOTION else Harm.WRONG,
        evidence={
            "bodies changed": len(changed),
            f"mass [kg] and moments [kg m²] of {names[0]} as written": _digits(meant[changed[0]]),
            "as compiled": _digits(compiled[changed[0]]),
            "change of motion as written": "not run" if change is None else change,
        },
        fix=WRITE,
        edits=AS_WRITTEN,
        change=change,
    )


def _digits(values: Array) -> str:
    return " ".join(f"{value:.6g}" for value in values)
