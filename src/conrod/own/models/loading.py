"""A user's own model, compiled: its elements by name, its keyframes, and whether its numbers are finite."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.errors import InvalidInput, unknown_choice
from conrod.own.files import check_readable

OWNERS = {"body": "body", "jnt": "joint", "geom": "geom", "site": "site", "eq": "equality", "key": "keyframe"}


def check_finite(model: mujoco.MjModel) -> None:
    """Refuse a model with a number that is none, which MuJoCo compiles without a word.

    Raises:
        InvalidInput: names the element and the field.
    """
    step = float(model.opt.timestep)
    if not (np.isfinite(step) and step > 0.0):
        raise InvalidInput(f"timestep = {step:g} is not a positive number")
    if not np.all(np.isfinite(model.opt.gravity)):
        raise InvalidInput("gravity is not finite")
    # Places first: what the compiler makes of them is as little a number.
    for field in sorted(
        (name for name in dir(model) if not name.startswith("_")), key=lambda n: not n.endswith("_pos")
    ):
        values = getattr(model, field)
        if isinstance(values, np.ndarray) and values.dtype.kind == "f" and not np.all(np.isfinite(values)):
            raise InvalidInput(f"{_owner(model, field, values)} is not finite")


def _owner(model: mujoco.MjModel, field: str, values: np.ndarray[tuple[int, ...], np.dtype[np.floating]]) -> str:
    kind = OWNERS.get(field.partition("_")[0], "")
    if kind in ("", "keyframe"):
        return field
    first = int(np.argwhere(~np.isfinite(values))[0][0])
    name = name_or_number(model, kind, first)
    return f"{field.partition('_')[2]} of {name if name == f'{kind} {first}' else f'{kind} {name}'}"


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


def start_words(model: mujoco.MjModel, keyframe: int | None) -> str:
    """A start in words."""
    return "its own pose" if keyframe is None else f"keyframe {names_of_keyframes(model)[keyframe] or keyframe}"


def load_model(path: Path) -> mujoco.MjModel:
    """The compiled model of an MJCF, URDF or binary model file.

    To be called in a process of its own, see `conrod.studies.execution.isolation`: the engine may abort on what
    it is given.

    Raises:
        InvalidInput: there is no such file, it does not parse or compile, or misses a file that it includes.
    """
    check_readable(path)
    with warnings_kept_quiet():
        try:
            if path.suffix.lower() == ".mjb":
                return mujoco.MjModel.from_binary_path(str(path))
            return mujoco.MjModel.from_xml_path(str(path))
        except ValueError as error:
            raise InvalidInput(f"{path}: MuJoCo cannot load it: {' '.join(str(error).split())}") from None


def element_id(model: mujoco.MjModel, kind: str, name: str) -> int:
    """Index of a named element.

    Args:
        kind: in lower case as in MuJoCo's names of kinds: body, joint, site, geom, sensor, equality, ...

    Raises:
        InvalidInput: the model has none of the name; names the nearest.
    """
    kind_id = getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}")
    found = int(mujoco.mj_name2id(model, kind_id, name))
    if found < 0:
        raise unknown_choice(kind, name, names_of(model, kind))
    return found


def names_of(model: mujoco.MjModel, kind: str) -> list[str]:
    """Names of all elements of a kind that have one."""
    kind_id = getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}")
    counts = {"body": model.nbody, "joint": model.njnt, "site": model.nsite, "geom": model.ngeom}
    counts |= {"sensor": model.nsensor, "equality": model.neq, "tendon": model.ntendon, "actuator": model.nu}
    return [name for name in (mujoco.mj_id2name(model, kind_id, i) for i in range(counts[kind])) if name]


def name_or_number(model: mujoco.MjModel, kind: str, index: int) -> str:
    """An element's name, or its number where it has none."""
    kind_id = getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}")
    return mujoco.mj_id2name(model, kind_id, index) or f"{kind} {index}"


def listed(names: Iterable[str], most: int = 6) -> str:
    """Names in a sentence, cut short where there are many."""
    every = list(names)
    return ", ".join(every[:most]) + (f" and {len(every) - most} more" if len(every) > most else "")
