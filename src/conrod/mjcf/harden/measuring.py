"""A model as it is, with its weights scaled alone, and hardened: the same run of each, at three steps."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import takewhile

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.exact.motion import Array
from conrod.mjcf.harden.closures import Closure, loops_of
from conrod.mjcf.harden.recipe import Recipe
from conrod.mjcf.harden.results import Orders, Variant
from conrod.mjcf.harden.runs import CLOSED, STATE, Pace, Swing, paced, swing
from conrod.mjcf.stepping import broken, looping_stepper
from conrod.runs.convergence import observed_order
from conrod.studies.frame.paired_timing import PairedCost, paired_cost

AS_IT_IS, WEIGHTS_ALONE, HARDENED = "as it is", "weights alone", "hardened"
LEVELS = (1, 2, 4)
# Under RK4 a sixteenth of the step leaves 1/65536 of the error; an eighth shows how well that is known.
REFERENCE, CHECK = 16, 8
# An error of less than this many times what the reference is known to says nothing about its order.
RESOLVED = 3.0
BIT = mujoco.mjtDisableBit
# Of the largest energy: where what is exchanged is less than this share of it, rounding hides the drift.
HIDDEN = 1e-9
# A machine whose bodies move by less than this share of its size stands.
STANDS = 1e-9


@dataclass(frozen=True)
class Measured:
    """Figures of the runs.

    Attributes:
        travel: the longest way of a body in the reference [m].
        reference_known_to: how far the two references are apart [m], or the rounding of a position where that is more;
            None where one of them broke.
        energy_without: what was left out where the energy was looked at.
        energy_note: why the energy says nothing.
    """

    variants: tuple[Variant, ...]
    travel: float | None
    reference_known_to: float | None
    energy_without: tuple[str, ...]
    energy_note: str


def measure(model: mujoco.MjModel, closures: Sequence[Closure], recipe: Recipe, state: Array, pace: Pace) -> Measured:
    """Run a model in three ways.

    The reference, which is the same for all three, is the hardened model under RK4 at a sixteenth of the step: the
    machine with its loops closed. What a soft loop adds to the motion is thus an error, as it is for the user.
    """
    precise = edited(model, replace(recipe, integrator="RK4"))
    reference, check = (swing(precise, state, pace.finer(times), closures) for times in (REFERENCE, CHECK))
    size = float(model.stat.extent)
    known = None
    if not (reference.broke or check.broke):
        known = max(distance(reference, check), float(np.finfo(float).eps) * size)
    travel = None if reference.broke else float(np.linalg.norm(reference.points - reference.points[0], axis=2).max())
    standing = stands(travel, size)
    bare, without = conservative(model)
    variants, note = [], "nothing moves" if standing else ""
    for name, edit in ((AS_IT_IS, None), (WEIGHTS_ALONE, recipe.weights_alone), (HARDENED, recipe)):
        changed = edited(model, edit)
        runs = [swing(changed, state, pace.finer(times), closures) for times in LEVELS]
        energy = energy_drift(edited(bare, edit), state, pace)
        note = note or energy.note
        variant = _variant(name, model, closures, runs, None if known is None else (reference, known))
        variants.append(replace(_without_orders(variant) if standing else variant, energy=energy.share))
    if note:
        variants = [replace(variant, energy=None) for variant in variants]
    return Measured(tuple(variants), travel, known, without, note)


def stands(travel: float | None, size: float) -> bool:
    """True for a machine of a size [m] that hardly moves."""
    return travel is not None and travel < STANDS * size


def edited(model: mujoco.MjModel, recipe: Recipe | None) -> mujoco.MjModel:
    """A copy of a model with a recipe applied."""
    changed = copy.copy(model)
    if recipe is not None:
        recipe.apply(changed)
    return changed


def distance(one: Swing, other: Swing) -> float:
    """The largest distance of a body in one run from where it is in another [m]."""
    return float(np.linalg.norm(one.points - other.points, axis=2).max(initial=0.0))


def cost(model: mujoco.MjModel, recipe: Recipe, state: Array, pace: Pace) -> PairedCost:
    """Cost of a hardened step over one as it is, both through the same motion, again and again from its start."""
    soft, hard = (paced(edited(model, edit), pace) for edit in (None, recipe))
    put = partial(mujoco.mj_setState, soft, state=state, sig=STATE)
    most = pace.samples * pace.stride
    return paired_cost(looping_stepper(hard, put, most), looping_stepper(soft, put, most))


def _variant(
    name: str,
    model: mujoco.MjModel,
    closures: Sequence[Closure],
    runs: Sequence[Swing],
    reference: tuple[Swing, float] | None,
) -> Variant:
    own = runs[0]
    if own.broke:
        return Variant(name, own.steps, own.broke)
    loops = loops_of(model, closures)
    variant = Variant(name, own.steps, None, tuple(float(value) for value in own.openings.max(axis=0)))
    unit = "m" if any(loop.unit == "m" for loop in loops) else "rad"
    widest = [float(run.openings[:, [loop.unit == unit for loop in loops]].max()) for run in runs]
    whole = not any(run.broke for run in runs)
    drift = None
    if reference is not None and whole:
        exact, known = reference
        drift = _orders([distance(run, exact) for run in runs], RESOLVED * known)
    return replace(
        variant,
        opening_over_size=widest[0] / float(model.stat.extent) if unit == "m" else None,
        closing=_orders(widest, CLOSED * (float(model.stat.extent) if unit == "m" else 1.0)) if whole else None,
        drift=drift,
        touching=own.touching,
        iterations=own.iterations,
    )


def _without_orders(variant: Variant) -> Variant:
    """Variant without orders, which a machine that stands does not have."""
    nothing = (None,) * (len(LEVELS) - 1)
    closing, drift = (
        None if orders is None else replace(orders, claimed=None, pairs=nothing)
        for orders in (variant.closing, variant.drift)
    )
    return replace(variant, closing=closing, drift=drift)


def _orders(values: Sequence[float], least: float) -> Orders:
    """Orders of values at the model's step, a half and a quarter of it, those down to `least` alone."""
    order = observed_order(LEVELS, values)
    resolved = sum(1 for _ in takewhile(lambda value: value > least, values))
    pairs = tuple(pair if k + 1 < resolved else None for k, pair in enumerate(order.pairs))
    return Orders(tuple(values), order.claimed if resolved == len(values) else None, pairs)


# -- energy ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class EnergyDrift:
    """Energy drift of one run.

    Attributes:
        share: largest change of the energy over the kinetic energy exchanged; None where it says nothing.
        note: why it says nothing.
    """

    share: float | None
    note: str = ""


def conservative(model: mujoco.MjModel) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    """A copy without what takes or gives energy, and the names of what was left out of it."""
    bare = copy.copy(model)
    bare.opt.disableflags |= int(
        BIT.mjDSBL_CONTACT | BIT.mjDSBL_LIMIT | BIT.mjDSBL_FRICTIONLOSS | BIT.mjDSBL_DAMPER | BIT.mjDSBL_ACTUATION
    )
    # MuJoCo's potential energy does not know of the gravity that it takes away.
    bare.body_gravcomp[:] = 0.0
    bare.opt.density = bare.opt.viscosity = 0.0
    bare.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    collides = bool(model.geom_contype.any() or model.geom_conaffinity.any() or model.npair)
    left_out = {
        "contacts": collides and not _off(model, BIT.mjDSBL_CONTACT),
        "limits": bool(model.jnt_limited.any() or model.tendon_limited.any()) and not _off(model, BIT.mjDSBL_LIMIT),
        "friction": bool(model.dof_frictionloss.any() or model.tendon_frictionloss.any()),
        "damping": bool(model.dof_damping.any() or model.tendon_damping.any()),
        "actuators": bool(model.nu),
        "gravity compensation": bool(model.body_gravcomp.any()),
        "fluid": bool(model.opt.density or model.opt.viscosity),
    }
    return bare, tuple(name for name, there in left_out.items() if there)


def energy_drift(model: mujoco.MjModel, state: Array, pace: Pace) -> EnergyDrift:
    """Largest change of the energy in a run of a conservative copy of a model."""
    run = paced(model, pace)
    data, aside = mujoco.MjData(run), mujoco.MjData(run)
    mujoco.mj_setState(run, data, state, STATE)
    found = []
    with warnings_kept_quiet():
        for sample in range(pace.samples + 1):
            aside.qpos[:], aside.qvel[:] = data.qpos, data.qvel
            mujoco.mj_fwdPosition(run, aside)
            mujoco.mj_fwdVelocity(run, aside)
            mujoco.mj_energyPos(run, aside)
            mujoco.mj_energyVel(run, aside)
            found.append(aside.energy.copy())
            if sample < pace.samples:
                mujoco.mj_step(run, data, pace.stride)
            if broken(data):
                return EnergyDrift(None, "without them a run breaks off")
    potential, kinetic = np.array(found).T
    exchanged = float(kinetic.max() - kinetic.min())
    largest = float(max(np.abs(potential).max(), kinetic.max()))
    if exchanged <= HIDDEN * largest:
        if exchanged == 0.0:
            return EnergyDrift(None, "nothing moves")
        return EnergyDrift(None, f"of {largest:.1e} J only {exchanged:.1e} J are exchanged: rounding hides it")
    total = potential + kinetic
    return EnergyDrift(float(np.abs(total - total[0]).max()) / exchanged)


def _off(model: mujoco.MjModel, flag: mujoco.mjtDisableBit) -> bool:
    return bool(int(model.opt.disableflags) & int(flag))
