"""A model whose lengths are in another unit than metres, as a model in metres that moves alike.

A file's numbers are of one system: its unit of length, kilograms, seconds. A quantity of dimension length^n is
multiplied by unit^n: a force (kg m/s^2) by unit, a torque and an inertia by unit^2, a stiffness along a slide (kg/s^2)
by 1. The model in metres then has the file's motion, times and softness; lengths, forces and energies are in SI.
"""

from __future__ import annotations

import mujoco
import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mjcf.equalities import equality_kind
from conrod.mjcf.loading import names_of, names_or_numbers
from conrod.mjcf.request import Controls

# Powers of length of the arrays that have one alone.
POWERS = {
    **dict.fromkeys(
        ("body_pos", "body_ipos", "body_margin", "jnt_pos", "geom_pos", "geom_size", "geom_rbound", "geom_aabb",
         "geom_margin", "geom_gap", "site_pos", "site_size", "cam_pos", "light_pos", "mesh_vert", "mesh_pos",
         "bvh_aabb", "hfield_size", "oct_aabb", "pair_margin", "pair_gap", "key_mpos", "tendon_width",
         "actuator_cranklength", "cam_pos0", "cam_poscom0", "light_pos0", "light_poscom0"),
        1,
    ),
    "body_inertia": 2,
}  # fmt: skip
SLIDE, FREE = int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_FREE)
WIDTH = 2  # place of the width, a length where the constraint is one, in solimp
# Arrays whose dimension depends on more than is looked at here: a model that uses them is refused.
UNKNOWN_ARRAYS = ("dof_dampingpoly", "jnt_stiffnesspoly", "tendon_dampingpoly", "tendon_stiffnesspoly",
                  "actuator_dampingpoly", "geom_fluid", "geom_adhesion", "pair_adhesion", "geom_surfacevel",
                  "jnt_springyield", "tendon_springyield")  # fmt: skip


def convert_to_metres(model: mujoco.MjModel, unit: float) -> None:
    """Convert a compiled model with lengths in a unit [m] to metres, in place.

    Raises:
        InvalidInput: the model has parts whose dimension is not known.
    """
    if unit == 1.0:
        return
    _refuse_unknown(model)
    statistics = float(model.stat.extent) * unit, np.array(model.stat.center) * unit
    for name, power in POWERS.items():
        getattr(model, name, np.zeros(0))[...] *= unit**power
    _convert_joints(model, unit)
    _convert_contacts(model, unit)
    tendons = [tendon_power(model, k) for k in range(model.ntendon)]
    _convert_tendons(model, unit, tendons)
    _convert_equalities(model, unit, tendons)
    for k in range(model.nu):
        _convert_actuator(model, k, unit)
    model.opt.gravity[:] *= unit
    model.opt.wind[:] *= unit
    model.opt.density /= unit**3
    model.opt.viscosity /= unit
    model.opt.o_margin *= unit
    model.opt.o_solimp[WIDTH] *= unit
    mujoco.mj_setConst(model, mujoco.MjData(model))
    model.stat.extent, model.stat.center[:] = statistics


def _refuse_unknown(model: mujoco.MjModel) -> None:
    """Refuse a model with parts, such as flexes and muscles, that are not converted to metres."""
    muscles = model.actuator_gaintype == int(mujoco.mjtGain.mjGAIN_MUSCLE)
    custom = model.actuator_biastype == int(mujoco.mjtBias.mjBIAS_USER)
    parts = {
        "flexes": model.nflex,
        "plugins": model.nplugin,
        "muscles": int(muscles.sum()),
        "actuators of a user's own kind": int(custom.sum()),
    }
    used = [name for name, count in parts.items() if count]
    used += [name for name in UNKNOWN_ARRAYS if np.any(getattr(model, name, 0.0))]
    if used:
        raise InvalidInput(f"--unit: it has {', '.join(used)}, which are not converted to metres")


# -- joints ------------------------------------------------------------------------------------------------------------


def coordinate_powers(model: mujoco.MjModel) -> Array:
    """Power of length of each coordinate (nq,): 1 along slides and of the place of free joints."""
    powers = np.zeros(model.nq)
    for joint, first in zip(model.jnt_type.tolist(), model.jnt_qposadr.tolist(), strict=True):
        powers[first : first + {SLIDE: 1, FREE: 3}.get(joint, 0)] = 1.0
    return powers


def rate_powers(model: mujoco.MjModel) -> Array:
    """Power of length of each rate (nv,)."""
    powers = np.zeros(model.nv)
    for joint, first in zip(model.jnt_type.tolist(), model.jnt_dofadr.tolist(), strict=True):
        powers[first : first + {SLIDE: 1, FREE: 3}.get(joint, 0)] = 1.0
    return powers


def _convert_joints(model: mujoco.MjModel, unit: float) -> None:
    # A force along a slide is kg m/s^2, a torque kg m^2/s^2; over the coordinate both are that less its own power.
    slide = (model.jnt_type == SLIDE).astype(float)
    model.jnt_range[:] *= unit ** slide[:, None]
    model.jnt_margin[:] *= unit**slide
    model.jnt_solimp[:, WIDTH] *= unit**slide
    model.jnt_stiffness[:] *= unit ** (2.0 - 2.0 * slide)
    model.jnt_actfrcrange[:] *= unit ** (2.0 - slide)[:, None]
    straight, coordinates = rate_powers(model), coordinate_powers(model)
    for name in ("dof_armature", "dof_damping"):
        getattr(model, name)[:] *= unit ** (2.0 - 2.0 * straight)
    model.dof_frictionloss[:] *= unit ** (2.0 - straight)
    for name in ("qpos0", "qpos_spring", "key_qpos"):
        getattr(model, name)[...] *= unit**coordinates
    model.key_qvel[...] *= unit**straight


def _convert_contacts(model: mujoco.MjModel, unit: float) -> None:
    # Torsional and rolling friction are lengths.
    model.geom_friction[:, 1:] *= unit
    model.geom_solimp[:, WIDTH] *= unit
    model.pair_friction[:, 2:] *= unit
    model.pair_solimp[:, WIDTH] *= unit


# -- tendons and equalities --------------------------------------------------------------------------------------------


def tendon_power(model: mujoco.MjModel, tendon: int) -> int:
    """Power of length of a tendon's length: 0 for a fixed tendon of hinges alone, which is an angle."""
    wraps = slice(int(model.tendon_adr[tendon]), int(model.tendon_adr[tendon] + model.tendon_num[tendon]))
    if np.any(model.wrap_type[wraps] != int(mujoco.mjtWrap.mjWRAP_JOINT)):
        return 1
    return int(np.any(model.jnt_type[model.wrap_objid[wraps]] == SLIDE))


def _convert_tendons(model: mujoco.MjModel, unit: float, powers: list[int]) -> None:
    for k, power in enumerate(powers):
        for name in ("tendon_range", "tendon_margin", "tendon_lengthspring"):
            getattr(model, name)[k] *= unit**power
        for name in ("tendon_stiffness", "tendon_damping", "tendon_armature"):
            getattr(model, name, np.zeros(model.ntendon))[k] *= unit ** (2 - 2 * power)
        for name in ("tendon_frictionloss", "tendon_actfrcrange"):
            getattr(model, name, np.zeros((model.ntendon, 2)))[k] *= unit ** (2 - power)
        model.tendon_solimp_lim[k, WIDTH] *= unit**power
        for wrap in range(int(model.tendon_adr[k]), int(model.tendon_adr[k] + model.tendon_num[k])):
            if int(model.wrap_type[wrap]) == int(mujoco.mjtWrap.mjWRAP_JOINT):
                slide = int(model.jnt_type[model.wrap_objid[wrap]]) == SLIDE
                model.wrap_prm[wrap] *= unit ** (power - int(slide))


def violation_power(model: mujoco.MjModel, index: int) -> int:
    """Power of length of what an equality holds at zero: of its first joint or tendon, 1 of bodies and sites."""
    kind, first = equality_kind(model, index), int(model.eq_obj1id[index])
    if kind == "joint":
        return int(model.jnt_type[first] == SLIDE)
    return tendon_power(model, first) if kind == "tendon" else 1


def _convert_equalities(model: mujoco.MjModel, unit: float, tendons: list[int]) -> None:
    for k in range(model.neq):
        kind = equality_kind(model, k)
        if kind in ("joint", "tendon"):
            powers = [
                0 if end < 0 else tendons[end] if kind == "tendon" else int(model.jnt_type[end] == SLIDE)
                for end in (int(model.eq_obj1id[k]), int(model.eq_obj2id[k]))
            ]
            # y = a0 + a1 x + a2 x^2 ..
            model.eq_data[k, :5] *= unit ** (powers[0] - np.arange(5.0) * powers[1])
            model.eq_solimp[k, WIDTH] *= unit ** powers[0]
            continue
        model.eq_data[k, :6] *= unit
        model.eq_solimp[k, WIDTH] *= unit
        if kind == "weld":
            model.eq_data[k, 10] *= unit  # its torquescale is a length


# -- actuators ---------------------------------------------------------------------------------------------------------


def actuator_powers(model: mujoco.MjModel, actuator: int) -> tuple[int, int, int]:
    """Powers of length of an actuator's force, of the length that it acts along, and of its control.

    The control of a servo is a length or an angle, or its rate: its bias depends on them. That of others is a number.
    """
    kind, end = mujoco.mjtTrn(int(model.actuator_trntype[actuator])), int(model.actuator_trnid[actuator, 0])
    if kind in (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT):
        length = int(int(model.jnt_type[end]) in (SLIDE, FREE))
    elif kind == mujoco.mjtTrn.mjTRN_TENDON:
        length = tendon_power(model, end)
    else:
        length = 1
    fixed = int(model.actuator_gaintype[actuator]) == int(mujoco.mjtGain.mjGAIN_FIXED)
    serves = fixed and bool(np.any(model.actuator_biasprm[actuator, 1:3]))
    return 2 - length, length, length if serves else 0


def _convert_actuator(model: mujoco.MjModel, k: int, unit: float) -> None:
    force, length, control = actuator_powers(model, k)
    gain, bias = model.actuator_gainprm[k], model.actuator_biasprm[k]
    gain[:3] *= unit ** np.array([force - control, force - length - control, force - length - control])
    bias[:3] *= unit ** np.array([force, force - length, force - length])
    for name in ("actuator_ctrlrange", "actuator_actrange"):
        getattr(model, name)[k] *= unit**control
    model.actuator_forcerange[k] *= unit**force
    model.actuator_lengthrange[k] *= unit**length
    for name in ("actuator_armature", "actuator_damping"):
        getattr(model, name, np.zeros(model.nu))[k] *= unit ** (force - length)
    if model.nkey:
        model.key_ctrl[:, k] *= unit**control
        first, count = int(model.actuator_actadr[k]), int(model.actuator_actnum[k])
        if first >= 0:
            model.key_act[:, first : first + count] *= unit**control
    if int(model.actuator_trntype[k]) == int(mujoco.mjtTrn.mjTRN_SITE):
        model.actuator_gear[k, 3:] *= unit  # torques beside forces


def controls_in_metres(model: mujoco.MjModel, controls: Controls, unit: float) -> Controls:
    """Convert controls from a file's length unit to metres, except controls of unknown actuators."""
    names = names_or_numbers(names_of(model, "actuator")) if unit != 1.0 else []
    powers = {name: actuator_powers(model, k)[2] for k, name in enumerate(names)}
    powers |= {str(k): power for k, power in enumerate(powers.values()) if str(k) not in powers}
    return tuple((name, value * unit ** powers.get(name, 0)) for name, value in controls)
