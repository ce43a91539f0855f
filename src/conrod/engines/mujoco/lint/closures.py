"""Equality constraints that close loops."""

from __future__ import annotations

import mujoco

from conrod.engines.mujoco.user_model.loading import name_or_number

CLOSING = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))


def closing(model: mujoco.MjModel, index: int) -> bool:
    """Whether an equality holds two bodies together."""
    return int(model.eq_type[index]) in CLOSING


def equality_bodies(model: mujoco.MjModel, index: int) -> tuple[int, int]:
    """The bodies that a connect or weld ties together."""
    ends = (int(model.eq_obj1id[index]), int(model.eq_obj2id[index]))
    if model.eq_objtype[index] == mujoco.mjtObj.mjOBJ_SITE:
        return int(model.site_bodyid[ends[0]]), int(model.site_bodyid[ends[1]])
    return ends


def closure_name(model: mujoco.MjModel, index: int) -> str:
    """How to speak of an equality: by its name, or by its number and what it ties together."""
    name = name_or_number(model, "equality", index)
    if mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_EQUALITY, index) or not closing(model, index):
        return name
    one, other = (name_or_number(model, "body", body) for body in equality_bodies(model, index))
    return f"{name} ({one} to {other})"
