"""Equality constraints of a compiled MuJoCo model: what they tie together, how far they are open, and a closed pose."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import mujoco
import numpy as np
from numpy.typing import NDArray

from conrod.engines.mujoco import compat
from conrod.engines.mujoco.model import equality_jacobian
from conrod.errors import list_names
from conrod.exact.motion import Array
from conrod.mjcf.loading import name_or_number

EQUALITY_KINDS = {
    mujoco.mjtEq.mjEQ_CONNECT: "connect",
    mujoco.mjtEq.mjEQ_WELD: "weld",
    mujoco.mjtEq.mjEQ_JOINT: "joint",
    mujoco.mjtEq.mjEQ_TENDON: "tendon",
}
MAX_CLOSING_STEPS = 50
REDUNDANT_ROW_SHARE = 1e-9  # singular values below this share of the largest are redundant rows


def row_equalities(data: mujoco.MjData) -> NDArray[np.int_]:
    """Index (r,) of the equality that each constraint row belongs to; equality rows come first."""
    return np.array(data.efc_id[: data.ne], dtype=int)


def constraint_violations(model: mujoco.MjModel, data: mujoco.MjData, extent: float) -> Array:
    """Violation of each equality (neq,) [m], an angle times an extent [m]; 0 for inactive ones."""
    return violation_reader(model, extent)(row_equalities(data), data.efc_pos[: data.ne])


def violation_reader(model: mujoco.MjModel, extent: float) -> Callable[[NDArray[np.int_], Array], Array]:
    """Return a function from violations of a model's rows (..., r) to those of its equalities (..., neq).

    Its first argument is the equality (r,) that each row belongs to. What an equality measures is looked up once.
    """
    lengths = [extent if measures_angles(model, k) else 1.0 for k in range(model.neq)]
    # MuJoCo has half of the turn's sine, times a scale of the weld.
    scales = [float(model.eq_data[k, 10]) if equality_kind(model, k) == "weld" else 0.0 for k in range(model.neq)]
    turns = [2.0 * extent / scale if scale else 0.0 for scale in scales]

    def violations(ids: NDArray[np.int_], gaps: Array) -> Array:
        found = np.zeros((*gaps.shape[:-1], model.neq))
        for index in dict.fromkeys(ids.tolist()):
            left = gaps[..., ids == index]
            found[..., index] = np.sqrt((left[..., :3] ** 2).sum(axis=-1)) * lengths[index]
            if turns[index]:
                turned = turns[index] * np.sqrt((left[..., 3:] ** 2).sum(axis=-1))
                found[..., index] = np.maximum(found[..., index], turned)
        return found

    return violations


def measures_angles(model: mujoco.MjModel, index: int) -> bool:
    """True if the violation of an equality is an angle: of a hinge, or of a fixed tendon without slides."""
    first, kind = int(model.eq_obj1id[index]), equality_kind(model, index)
    if kind == "tendon":
        wraps = slice(int(model.tendon_adr[first]), int(model.tendon_adr[first] + model.tendon_num[first]))
        if np.any(model.wrap_type[wraps] != mujoco.mjtWrap.mjWRAP_JOINT):
            return False
        return not np.any(model.jnt_type[model.wrap_objid[wraps]] == mujoco.mjtJoint.mjJNT_SLIDE)
    return bool(kind == "joint" and model.jnt_type[first] == mujoco.mjtJoint.mjJNT_HINGE)


def close_loops(model: mujoco.MjModel, data: mujoco.MjData, closed: float) -> bool:
    """Move data to the nearest pose with violations of at most `closed`, by Newton iteration; False if none."""
    for _ in range(MAX_CLOSING_STEPS):
        mujoco.mj_fwdPosition(model, data)
        gaps, jacobian = np.array(data.efc_pos[: data.ne]), equality_jacobian(model, data)
        if not (np.isfinite(gaps).all() and np.isfinite(jacobian).all()):
            return False
        if np.abs(gaps).max(initial=0.0) <= closed:
            return True
        mujoco.mj_integratePos(model, data.qpos, -np.linalg.lstsq(jacobian, gaps, rcond=REDUNDANT_ROW_SHARE)[0], 1.0)
    return False


def equality_kind(model: mujoco.MjModel, index: int) -> str:
    """Kind of an equality: connect, weld, joint or tendon; empty for an equality of a flex."""
    return EQUALITY_KINDS.get(mujoco.mjtEq(model.eq_type[index]), "")


def ties_bodies(model: mujoco.MjModel, index: int) -> bool:
    """Return True for a connect or a weld."""
    return equality_kind(model, index) in ("connect", "weld")


def closure_name(model: mujoco.MjModel, index: int) -> str:
    """Name of an equality, or its number and the elements that it ties together."""
    name, kind = name_or_number(model, "equality", index), equality_kind(model, index)
    if mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_EQUALITY, index) or not kind:
        return name
    bodies = ties_bodies(model, index)
    ends = (
        compat.equality_bodies(model, index) if bodies else (int(model.eq_obj1id[index]), int(model.eq_obj2id[index]))
    )
    named = [name_or_number(model, "body" if bodies else kind, end) for end in ends if end >= 0]
    return f"{name} ({' to '.join(named)})"


# -- closures that do not act ------------------------------------------------------------------------------------------

FLAGS = {"equality": mujoco.mjtDisableBit.mjDSBL_EQUALITY, "constraint": mujoco.mjtDisableBit.mjDSBL_CONSTRAINT}


def disabling_flag(model: mujoco.MjModel) -> str:
    """Name of the flag in `<option>` that switches all equalities off; empty where none does."""
    return next((name for name, bit in FLAGS.items() if model.opt.disableflags & bit), "")


def inactive_closures(model: mujoco.MjModel) -> tuple[str, ...]:
    """Names of the equalities that do not act from the start."""
    everything = bool(disabling_flag(model))
    return tuple(closure_name(model, k) for k in range(model.neq) if everything or not model.eq_active0[k])


def inactive_words(model: mujoco.MjModel) -> str:
    """'closure slider-pin is inactive (active="false")': the equalities that do not act; empty where all do."""
    if not (names := inactive_closures(model)):
        return ""
    cause = f'<flag {flag}="disable"/>' if (flag := disabling_flag(model)) else 'active="false"'
    subject = f"closure {names[0]} is" if len(names) == 1 else f"closures {list_names(names)} are"
    return f"{subject} inactive ({cause})"


# -- handles -----------------------------------------------------------------------------------------------------------


def mocap_of(model: mujoco.MjModel, body: int) -> int | None:
    """The mocap body that a body is or is fixed to, or None."""
    while body and model.body_mocapid[body] < 0:
        if model.body_jntnum[body]:
            return None
        body = int(model.body_parentid[body])
    return body or None


def is_handle(model: mujoco.MjModel, index: int) -> bool:
    """True for a connect or weld to a mocap body, which drags a body by hand and closes no loop."""
    return ties_bodies(model, index) and any(mocap_of(model, end) for end in compat.equality_bodies(model, index))


def handle_indices(model: mujoco.MjModel) -> tuple[int, ...]:
    """Indices of the handles that act from the start."""
    acting = [] if disabling_flag(model) else np.flatnonzero(model.eq_active0).tolist()
    return tuple(index for index in acting if is_handle(model, index))


def handle_words(model: mujoco.MjModel, indices: Iterable[int]) -> str:
    """Say which closures are handles: 'hold is a handle: it drags hand after the mocap body stylus'."""
    words = []
    for index in indices:
        ends = compat.equality_bodies(model, index)
        mocaps = [mocap for end in ends if (mocap := mocap_of(model, end)) is not None]
        dragged = next((end for end in ends if mocap_of(model, end) is None), ends[-1])
        names = (name_or_number(model, "body", body) for body in (dragged, mocaps[0]))
        words.append("{} is a handle: it drags {} after the mocap body {}".format(closure_name(model, index), *names))
    return "; ".join(words)
