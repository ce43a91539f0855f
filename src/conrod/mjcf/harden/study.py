"""Hardening of the model of a file, phase by phase."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from conrod.errors import InvalidInput
from conrod.mjcf.harden.recipe import (
    active_closures,
    edited,
    nothing_to_do,
    python_lines,
    recipe_for,
    soft_on_purpose,
    to_know,
)
from conrod.mjcf.harden.results import HardenedModel, Request, Variant
from conrod.mjcf.harden.runs import Pace, Reference, cost, start_of
from conrod.own.models.loading import check_finite, load_model

AS_IT_IS, HARDENED = "as it is", "hardened"
SAMPLES = 500
LEAST_STEPS, MOST_STEPS = 20, 200_000
# A machine whose bodies move by less than this share of its size stands.
STANDS = 1e-9
# Loops that open by so many times as much are worse, unless they are closed to rounding [of the model's size].
WORSE, ROUNDING = 2.0, 1e-9
ADVICE = "a smaller step of the model may help"
FORCE = "--force hardens it all the same"


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
    pace = pace_of(model, request.seconds)
    closures = active_closures(model)
    notes = to_know(model, closures)
    found = HardenedModel(str(path), mujoco.__version__, warnings=notes)
    if reason := nothing_to_do(model, closures):
        return replace(found, refusals=(reason,))
    soft = soft_on_purpose(model, closures)
    if soft and not request.force:
        return replace(found, refusals=tuple(f"{reason}; {FORCE}" for reason in soft))
    recipe, start = recipe_for(model, closures), start_of(model, request)
    hard = edited(model, recipe)
    reference = Reference.of(hard, start.state, pace, closures)
    before, after = (
        reference.variant(name, one, start.state, pace, closures) for name, one in ((AS_IT_IS, model), (HARDENED, hard))
    )
    found = replace(
        found,
        size=float(model.stat.extent),
        timestep=pace.timestep,
        seconds=pace.timestep * pace.samples * pace.stride,
        start=start.name,
        start_opening=start.given,
        start_closed=start.closed,
        loops=tuple(f"{one.kind} {one.name}" for one in closures),
        factor=recipe.factor,
        lines=python_lines(model, recipe, path.absolute()),
        variants=(before, after),
        travel=reference.travel,
        reference_known_to=reference.known_to,
    )
    harm = _harm(found, before, after)
    refused = bool(harm) and not request.force
    told = [harm] if harm and not refused else []
    return replace(
        found,
        refusals=(f"{harm}; {FORCE}",) if refused else (),
        warnings=(*soft, *told, *_doubts(found), *notes),
        cost=None if before.broke or after.broke else cost(model, hard, start.state, pace),
        content=None if refused or not request.content else binary(hard),
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
    if after.broke:
        hardened = f"the run breaks off hardened after {after.steps} steps ({after.broke}), and as it is"
        if before.broke:
            return f"{hardened} after {before.steps} ({before.broke}): nothing shows what hardening does"
        return f"{hardened} it does not: {ADVICE}"
    then, now = (max(one.openings or (), default=0.0) for one in (before, after))
    if not before.broke and now > max(WORSE * then, ROUNDING * found.size):
        return f"its loops open more, {1e3 * now:.1e} mm and as it is {1e3 * then:.1e} mm: {ADVICE}"
    return ""


def _doubts(found: HardenedModel) -> Iterator[str]:
    """Reasons to doubt the figures."""
    if not found.start_closed:
        yield "no pose near the start closes the loops: the runs start with them open"
    if found.travel is not None and found.travel < STANDS * found.size:
        yield (
            f"nothing moves in these runs (travel {found.travel:.1e} m): they show how far the loops open at rest, "
            "and nothing else; --keyframe KEY starts others, --ctrl NAME=VALUE commands a motion"
        )


def binary(model: mujoco.MjModel) -> bytes:
    """The model as MuJoCo saves it (mj_saveModel)."""
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()
