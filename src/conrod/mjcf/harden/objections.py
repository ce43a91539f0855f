"""Objections to hardening a model, and notes for its user."""

from __future__ import annotations

import copy
from collections.abc import Sequence

import mujoco
import numpy as np

from conrod.mjcf.equalities import kind_of
from conrod.mjcf.harden.closures import Closure, called, softer_than_stock
from conrod.mjcf.harden.recipe import Weights
from conrod.own.models.loading import listed, name_or_number

# A weight of less than this share of what MuJoCo would give it has been scaled.
SCALED = 0.5


def nothing_to_do(model: mujoco.MjModel, closures: Sequence[Closure]) -> str:
    """Reason why a model cannot be hardened, forced or not; empty where it can."""
    if model.body_invweight0.dtype != np.float64:
        return "this build of MuJoCo calculates in single precision, where hardening costs more digits than it gives"
    if not closures:
        off = [name_or_number(model, "equality", i) for i in range(model.neq) if kind_of(model, i)]
        inactive = f"none of its equality constraints is active at the start: {listed(off)}"
        return (
            inactive if off else "it has no closed loop: nothing to harden (joints of its tree are exact as they are)"
        )
    share = largest_share(model, Weights.of(closures))
    if share is None:
        return "what its closures hold has no inverse weight: nothing to harden"
    return f"it is hardened already: its weights are {share:.1e} of what they were" if share < SCALED else ""


def largest_share(model: mujoco.MjModel, weights: Weights) -> float | None:
    """The largest share that weights are of what `mj_setConst` makes them; None where it makes them all zero."""
    made = copy.copy(model)
    mujoco.mj_setConst(made, mujoco.MjData(made))
    stock = weights.values(made)
    there = stock > 0.0
    return float((weights.values(model)[there] / stock[there]).max()) if there.any() else None


def soft_on_purpose(model: mujoco.MjModel, closures: Sequence[Closure]) -> tuple[str, ...]:
    """Closures that seem to be meant to give way."""
    given, softer, dragged = list[str](), list[str](), list[str]()
    for one in closures:
        if one.holder == "body" and any(model.body_mocapid[body] >= 0 for body in one.ends):
            dragged.append(one.name)
        elif model.eq_solref[one.index, 0] <= 0.0:
            given.append(one.name)
        elif softer_than_stock(model, one.index):
            softer.append(one.name)
    reasons = (
        (given, "stiffness and damping are given as such (solref <= 0)"),
        (softer, "softer than MuJoCo's stock setting"),
        (dragged, "it drags a body after a mocap body"),
    )
    return tuple(f"{listed(names)}: {why}, so meant to give way" for names, why in reasons if names)


def to_know(model: mujoco.MjModel, closures: Sequence[Closure]) -> tuple[str, ...]:
    """Limits of the hardened model."""
    curved = [one.name for one in closures if one.curved]
    off = [
        name_or_number(model, "equality", i) for i in range(model.neq) if kind_of(model, i) and not model.eq_active0[i]
    ]
    other = [name_or_number(model, "equality", i) for i in range(model.neq) if not kind_of(model, i)]
    contacts = _with_friction(model, Weights.of(closures))
    found = (
        (
            curved,
            "MuJoCo's acceleration of it lacks the part of the velocity: hardened or not, it opens with the square of "
            "its time constant, so that is kept; the reference has this error too, so the drift does not show it",
        ),
        (off, "not active at the start, so not hardened"),
        (other, "of a flex, so not hardened"),
        (contacts, "contacts with friction harden there too"),
    )
    return tuple(f"{listed(names)}: {what}" for names, what in found if names)


def touching_scaled(model: mujoco.MjModel, weights: Weights) -> tuple[str, ...]:
    """Geoms that can collide and joint limits whose own weights are scaled."""
    joints = sorted({int(model.dof_jntid[dof]) for dof in weights.indices["dof"]})
    limits = [joint for joint in joints if model.jnt_limited[joint]]
    return (
        *(called(model, "geom", geom) for geom in _colliding(model, weights)),
        *(f"limit of {called(model, 'joint', joint)}" for joint in limits),
    )


def _colliding(model: mujoco.MjModel, weights: Weights) -> list[int]:
    if int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_CONTACT):
        return []
    paired = set(model.pair_geom1.tolist()) | set(model.pair_geom2.tolist())
    able = [
        geom in paired or bool(model.geom_contype[geom] or model.geom_conaffinity[geom]) for geom in range(model.ngeom)
    ]
    return [
        geom for geom in range(model.ngeom) if able[geom] and int(model.geom_bodyid[geom]) in weights.indices["body"]
    ]


def _with_friction(model: mujoco.MjModel, weights: Weights) -> list[str]:
    # The larger contact dimension of two geoms counts, so that one of 1 may well slide with friction.
    if not np.any(model.geom_condim > 1) and not np.any(model.pair_dim > 1):
        return []
    return [called(model, "geom", geom) for geom in _colliding(model, weights)]
