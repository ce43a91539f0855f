"""The study of what moves a model: its mobility, its actuators, its keyframes and the energy of its free swing."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping

import mujoco

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.mjcf.equalities import close_loops
from conrod.models.inspection.actuators import try_actuators
from conrod.models.inspection.energy import free_energy
from conrod.models.inspection.following import follow_laws
from conrod.models.inspection.keyframe_holds import hold_keyframes
from conrod.models.inspection.moving import CLOSED, count_model_mobility
from conrod.models.inspection.results import Moving


def study_moving(
    model: mujoco.MjModel,
    start: mujoco.MjData,
    drives: Mapping[str, str] | None = None,
    progress: Callable[[str], object] = lambda name: None,
    watch: Callable[[mujoco.MjData], object] = lambda data: None,
) -> Moving:
    """Study what moves a model, from the closed pose nearest to a start.

    Args:
        start: data at the start, as `conrod.mjcf.loading.data_at_start` gives it; it is not changed.
        drives: laws that controls of actuators or joints follow; without any all actuators are tried.
        progress: called with the name of each part before it is tried.
        watch: called with the data before each step of a run along the given laws.

    Raises:
        InvalidInput: nothing has the name of a drive, or it cannot follow its law.
    """
    closed = copy.copy(start)
    with silence_warnings():
        if not close_loops(model, closed, CLOSED * float(model.stat.extent)):
            closed = copy.copy(start)
    mobility = count_model_mobility(model, start)
    if drives:
        return Moving(mobility, (), followed=follow_laws(model, closed, drives, watch))
    return Moving(mobility, try_actuators(model, closed, progress), hold_keyframes(model), free_energy(model, start))
