"""Whether all that a model says are numbers."""

from __future__ import annotations

import mujoco
import numpy as np

from conrod.engines.mujoco.user_model.loading import name_or_number
from conrod.errors import InvalidInput

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
