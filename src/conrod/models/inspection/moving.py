"""What moves a model: its degrees of freedom, its actuators, its keyframes and the energy of its free swing."""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.engines.mujoco.model import equality_jacobian
from conrod.exact.space.mobility import numerical_rank
from conrod.mjcf.equalities import close_loops, closure_name, handle_indices, handle_words, row_equalities
from conrod.mjcf.loading import name_or_number
from conrod.models.inspection.actuator_kinds import read_actuators
from conrod.models.inspection.actuator_runs import free_motions, moment
from conrod.models.inspection.actuators import try_actuators
from conrod.models.inspection.energy import free_energy
from conrod.models.inspection.following import follow_laws
from conrod.models.inspection.keyframe_holds import hold_keyframes
from conrod.models.inspection.moving_results import ModelMobility
from conrod.models.inspection.results import Moving

CLOSED = 1e-10  # of the model's extent, that closures are closed to before their rank is counted
MIN_SHARE = 1e-6  # of a motion, from which on a joint takes part in it
MAX_DOFS = 400  # degrees of freedom up to which ranks are counted


def count_model_mobility(model: mujoco.MjModel, start: mujoco.MjData) -> ModelMobility | None:
    """Count the degrees of freedom of a model at the closed pose nearest to a start; None if it has too many.

    Args:
        start: data at the start; it is not changed.
    """
    if model.nv > MAX_DOFS:
        return None
    data = copy.copy(start)
    with silence_warnings():
        closed = close_loops(model, data, CLOSED * float(model.stat.extent))
        if not closed:
            data = copy.copy(start)
        mujoco.mj_forward(model, data)
    jacobian, owners = equality_jacobian(model, data), row_equalities(data)
    closing = ~np.isin(owners, handle_indices(model))
    jacobian, owners = jacobian[closing], owners[closing]
    basis, redundant, before = free_motions(model, jacobian), dict[str, int](), 0
    for k in dict.fromkeys(owners.tolist()):
        rows = np.flatnonzero(owners == k)
        after = numerical_rank(jacobian[: rows[-1] + 1])
        if spare := len(rows) - (after - before):
            redundant[closure_name(model, k)] = spare
        before = after
    tried = [one for one in read_actuators(model) if not one.untried]
    pushes = np.array([moment(model, data, one) @ basis for one in tried]).reshape(len(tried), basis.shape[1])
    scale = np.abs(pushes).max(axis=1, initial=0.0)
    pushes = pushes[scale > MIN_SHARE] / scale[scale > MIN_SHARE, None]
    driven = numerical_rank(pushes)
    left = basis @ np.linalg.svd(pushes)[2][driven:].T if len(pushes) else basis
    moved = np.abs(left).max(axis=1, initial=0.0)
    names = [name_or_number(model, "joint", int(j)) for j in model.dof_jntid]
    undriven = dict.fromkeys(n for n, size in zip(names, moved.tolist(), strict=True) if size > MIN_SHARE)
    return ModelMobility(
        model.nv, len(owners), before, redundant, int(np.sum(scale > MIN_SHARE)), driven, tuple(undriven),
        handle_words(model, handle_indices(model)), closed,
    )  # fmt: skip


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
