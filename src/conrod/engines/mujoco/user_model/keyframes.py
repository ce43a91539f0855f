"""Which pose a run of a user's model starts from: its first keyframe, another one, or the model's own pose."""

from __future__ import annotations

import mujoco

from conrod.errors import unknown_choice

# What a user names the model's own pose, after MuJoCo's field.
OWN_POSE = "qpos0"


def names_of_keyframes(model: mujoco.MjModel) -> list[str]:
    """Names of the keyframes, in order; empty where one has none."""
    return [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_KEY, index) or "" for index in range(model.nkey)]


def keyframe_to_start_from(model: mujoco.MjModel, given: str | None) -> int | None:
    """Index of a keyframe; None for the model's own pose.

    Args:
        given: a keyframe's name or number, or `OWN_POSE`; None for the first keyframe, or the own pose without any.

    Raises:
        InvalidInput: the model has no such keyframe; names the nearest.
    """
    names = [name or str(index) for index, name in enumerate(names_of_keyframes(model))]
    if given is None:
        return 0 if names else None
    if given in names:
        return names.index(given)
    if given == OWN_POSE:
        return None
    if given.isdecimal() and int(given) < len(names):
        return int(given)
    raise unknown_choice("keyframe", given, [*names, OWN_POSE])


def told_start(model: mujoco.MjModel, keyframe: int | None) -> str:
    """How to speak of a start."""
    return "its own pose" if keyframe is None else f"keyframe {names_of_keyframes(model)[keyframe] or keyframe}"
