"""A user's own model, compiled; the file is only read."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import mujoco

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.errors import InvalidInput, unknown_choice


def load_model(path: Path) -> mujoco.MjModel:
    """The compiled model of an MJCF, URDF or binary model file.

    To be called in a process of its own, see `conrod.confined`: the engine may abort on what it is given.

    Raises:
        InvalidInput: there is no such file, it does not parse or compile, or misses a file that it includes.
    """
    if not path.is_file():
        raise InvalidInput(f"{path}: there is no such file" if not path.exists() else f"{path}: it is not a file")
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
    """How to speak of an element: by its name, or by its number where it has none."""
    kind_id = getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}")
    return mujoco.mj_id2name(model, kind_id, index) or f"{kind} {index}"


def listed(names: Iterable[str], most: int = 6) -> str:
    """Names in a sentence, cut short where there are many."""
    every = list(names)
    return ", ".join(every[:most]) + (f" and {len(every) - most} more" if len(every) > most else "")
