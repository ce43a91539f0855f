"""The legged model that hardening is tested on."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import mujoco

from conrod.exact.motion import Array
from conrod.mjcf.harden.recipe import active_closures
from conrod.mjcf.harden.runs import Pace, swing

LEGGED = Path(__file__).parent / "models" / "legged.xml"


@cache
def legged() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(LEGGED))


def opening_of(model: mujoco.MjModel, state: Array, pace: Pace) -> float:
    return float(swing(model, state, pace, active_closures(model)).openings.max())
