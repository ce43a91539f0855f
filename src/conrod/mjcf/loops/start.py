"""The pose that a file's own run starts in: loops that are open there, and the nearest pose that closes them."""

from __future__ import annotations

import copy

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import warnings_kept_quiet
from conrod.exact.motion import Array
from conrod.mjcf.equalities import close_loops, closure_name, handles, openings
from conrod.own.models.request import AJAR, OpenStart

CLOSED = 1e-12  # of the machine's extent
DIGITS, PLACES = 10, 12  # of a pose in words: what they leave open is far below what is said to be open


def open_start(model: mujoco.MjModel, data: mujoco.MjData, extent: float, pose: str) -> OpenStart | None:
    """Find the loops that are open in a pose; None where all are closed.

    Args:
        data: at the pose.
        extent: of the machine, in the model's unit of length.
        pose: in words.
    """
    looked_at = copy.copy(data)
    with warnings_kept_quiet():
        mujoco.mj_fwdPosition(model, looked_at)
        found, dragged = openings(model, looked_at, extent), handles(model)
        gaps = {closure_name(model, k): float(found[k]) for k in range(model.neq) if k not in dragged}
        ajar = {name: gap for name, gap in gaps.items() if gap > AJAR * extent}
        if not ajar:
            return None
        closed = close_loops(model, looked_at, CLOSED * extent)
    return OpenStart(pose, ajar, extent, pose_words(looked_at.qpos) if closed else "")


def pose_words(coordinates: Array) -> str:
    """Coordinates (nq,) as MJCF's `qpos` has them."""
    return " ".join(f"{value:.{DIGITS}g}" for value in np.round(coordinates, PLACES) + 0.0)
