"""Hardening of the model of a file, phase by phase."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from conrod.errors import InvalidInput
from conrod.mjcf.harden.closures import active_closures, loops_of
from conrod.mjcf.harden.measuring import AS_IT_IS, HARDENED, cost, measured, stands
from conrod.mjcf.harden.recipe import (
    edited,
    nothing_to_do,
    python_lines,
    recipe_for,
    soft_on_purpose,
    to_know,
    touching_scaled,
)
from conrod.mjcf.harden.results import HardenedModel, Request, Variant
from conrod.mjcf.harden.runs import Pace, Start, largest_by_unit, start_of
from conrod.own.models.loading import check_finite, controls_at_start, load_model

SAMPLES = 500
LEAST_STEPS, MOST_STEPS = 20, 200_000
# Loops that open by so many times as much are worse, unless they are closed to rounding [of the model's size, rad].
WORSE, ROUNDING = 2.0, 1e-9
# A change of the rates at the start of more than this share is worth a word.
RATES = 1e-6
ADVICE = "another --integrator or --solref, or a smaller step of the model, may help"
FORCE = "--force hardens it all the same"
# A drift that is left of more than this share of what it was is no gain worth the name.
BETTER = 0.5


def harden_file(path: Path, request: Request) -> HardenedModel:
    """Harden the model of a file, and show on its own motion what that changes. The file is only read.

    To be called in a process of its own, see `conrod.studies.execution.isolation`.

    Raises:
        InvalidInput: the model cannot be loaded or says what is no number, has no such keyframe, or the run would be
            too short or too long.
    """
    # By its whole path, as in the lines: MuJoCo keeps in the model where its assets are.
    model = load_model(path.absolute())
    try:
        check_finite(model)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None
    try:
        return _hardened(path, model, request)
    except mujoco.FatalError as error:
        raise InvalidInput(f"{path}: MuJoCo gives up on it: {' '.join(str(error).split())}") from None


def _hardened(path: Path, model: mujoco.MjModel, request: Request) -> HardenedModel:
    controls = controls_at_start(model, request.keyframe, request.controls)
    pace = pace_of(model, request.seconds)
    closures = active_closures(model)
    notes = to_know(model, closures)
    found = HardenedModel(str(path), mujoco.__version__, warnings=notes)
    if reason := nothing_to_do(model, closures):
        return replace(found, refusals=(reason,))
    soft = soft_on_purpose(model, closures)
    if soft and not request.force:
        return replace(found, refusals=tuple(f"{reason}; {FORCE}" for reason in soft))
    recipe = recipe_for(model, closures, request)
    start = start_of(model, request, closures)
    found = replace(
        found,
        size=float(model.stat.extent),
        timestep=pace.timestep,
        seconds=pace.timestep * pace.samples * pace.stride,
        start=start.name,
        start_opening=start.given,
        start_closed=start.closed,
        loops=loops_of(closures),
        factor=recipe.factor,
        scaled=recipe.weights.names(model),
        lines=python_lines(model, recipe, path.absolute()),
        touching_scaled=touching_scaled(model, recipe.weights),
    )
    found = measured(found, model, closures, recipe, start.state, pace)
    before, after = (next(v for v in found.variants if v.name == name) for name in (AS_IT_IS, HARDENED))
    harm = _harm(found, before, after)
    idle = bool(controls) and not any(controls.values())
    refused = bool(harm) and not request.force
    runs = before.broke is None and after.broke is None
    return replace(
        found,
        refusals=(f"{harm}; {FORCE}",) if refused else (),
        warnings=(
            *soft,
            *((harm,) if harm and not refused else ()),
            *_doubts(found, start, before, after, idle),
            *notes,
        ),
        cost=cost(model, recipe, start.state, pace) if runs else None,
        content=None if refused or not request.content else binary(edited(model, recipe)),
    )


def pace_of(model: mujoco.MjModel, seconds: float) -> Pace:
    """Steps of a run.

    Raises:
        InvalidInput: they are too few or too many.
    """
    timestep = float(model.opt.timestep)
    least, most = LEAST_STEPS * timestep, MOST_STEPS * timestep
    if not least <= seconds <= most:
        raise InvalidInput(
            f"--seconds {seconds:g} is out of range: {least:.3g} to {most:.3g} at the model's step of {timestep:g} s"
        )
    steps = math.ceil(seconds / timestep - 1e-9)
    stride = math.ceil(steps / SAMPLES)
    return Pace(math.ceil(steps / stride), stride, timestep)


def _harm(found: HardenedModel, before: Variant, after: Variant) -> str:
    """Reason why the hardened model is worse than none; empty where it is not."""
    if before.broke is not None and after.broke is not None:
        return (
            f"the run breaks off as it is after {before.steps} steps ({before.broke}), and hardened after "
            f"{after.steps} ({after.broke}): nothing shows what hardening does"
        )
    if before.broke is not None:
        return ""
    if after.broke is not None:
        return (
            f"the run breaks off after {after.steps} of {before.steps} steps ({after.broke}), and as it is "
            f"it does not: {ADVICE}"
        )
    for unit, least in (("m", ROUNDING * found.size), ("rad", ROUNDING)):
        then, now = (largest_by_unit(found.loops, one.openings or ()).get(unit, 0.0) for one in (before, after))
        if now > max(WORSE * then, least):
            return f"its loops open more, {now:.1e} {unit} and as it is {then:.1e}: {ADVICE}"
    return ""


def _doubts(found: HardenedModel, start: Start, before: Variant, after: Variant, idle: bool) -> tuple[str, ...]:
    """Reasons to doubt the figures, or the hardened model."""
    doubts = []
    if not start.closed:
        doubts.append("no pose near the start closes the loops: the runs start with them open")
    if idle:
        doubts.append("all controls are 0, so that nothing commands a motion: --ctrl NAME=VALUE does")
    if start.rates_changed > RATES:
        doubts.append(
            f"the rates of the start would open its loops: the runs start with the nearest that do not, changed by "
            f"{start.rates_changed:.1e} of the largest"
        )
    if before.broke is not None and after.broke is None:
        doubts.append(f"as it is, the run breaks off after {before.steps} steps ({before.broke})")
    if stands(found.travel, found.size):
        doubts.append(
            f"nothing moves in these runs (travel {found.travel:.1e} m): they show how far the loops open at rest, "
            "and nothing else; --keyframe KEY starts others"
        )
    elif before.drift and after.drift and found.reference_known_to is not None:
        then, now = before.drift.values[0], after.drift.values[0]
        if now > BETTER * then and now > found.reference_known_to:
            doubts.append("the motion is hardly any better than it was: the step is the larger part of the error")
    return tuple(doubts)


def binary(model: mujoco.MjModel) -> bytes:
    """The model as MuJoCo saves it (mj_saveModel)."""
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()
