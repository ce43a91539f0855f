"""Hardening of the model of a file, and its runs as it is and hardened against the machine with its loops closed."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np

from conrod.comparison.other_forces import LACKING, acting_sentences, merge_forces
from conrod.engines.mujoco import compat
from conrod.engines.mujoco.compiled_edits import set_step
from conrod.engines.mujoco.model import equality_jacobian
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.execution.paired_timing import time_stepper_pair
from conrod.mjcf.edits import apply_recipe
from conrod.mjcf.equalities import REDUNDANT_ROW_SHARE, close_loops, constraint_violations, handle_indices
from conrod.mjcf.hardenable import active_closures, hardenable_closures
from conrod.mjcf.loading import check_finite, data_at_start, load_model, start_words
from conrod.mjcf.request import Controls
from conrod.mjcf.runs import Run, looping_stepper, run, state_of, user_model_errors
from conrod.mjcf.unit_of_length import controls_in_metres, convert_to_metres
from conrod.models.harden import recipe as recipes
from conrod.models.harden.results import HardenedModel, HardeningRun

CLOSING_TOLERANCE = 1e-12  # of the model's size
# RK4's error has terms of h^4, h^5, .. and the motion at a step of zero is extrapolated from runs at these parts of the
# step, if their differences fall as they then do: by 16, or nearly.
EXTRAPOLATED_REFINEMENTS = (1, 2, 4)
MIN_DIFFERENCE_RATIO, MAX_DIFFERENCE_RATIO = 11.0, 23.0
# Where they do not, as through contacts, a sixteenth of the step leaves 1/65536 of an error of order 4; an eighth shows
# how well that is known.
REFERENCE_REFINEMENT, CHECK_REFINEMENT = 16, 8
MAX_SAMPLES = 500
MIN_STEPS, MAX_STEPS = 20, 200_000
# A machine whose bodies move by less than this share of its size stands.
STANDSTILL_SHARE = 1e-9
# Loops that open by so many times as much are worse, unless they are closed to rounding [of the model's size].
WORSE_FACTOR, CLOSED_SHARE = 2.0, 1e-9
USUAL_SECONDS = 1.0  # length of the runs
ADVICE = "a smaller step of the model may help"
FORCE = "--force hardens it all the same"


def harden_file(
    path: Path,
    keyframe: str | None = None,
    seconds: float | None = None,
    force: bool = False,
    content: bool = True,
    controls: Controls = (),
    unit: float = 1.0,
) -> HardenedModel:
    """Harden a model and compare runs of it as it is and hardened; the file is only read.

    Args:
        keyframe: keyframe that the runs start from, as in `data_at_start`.
        seconds: length of the runs [s]; None for `USUAL_SECONDS`, or what fits the step of the model.
        force: harden what seems to be soft on purpose, or is worse when hard.
        content: whether the result has the hardened model, not only its figures.
        controls: inputs of actuators in place of the keyframe's, held through the runs.
        unit: unit of the file's lengths [m]; the runs are in metres, the hardened model is in the file's unit.

    Raises:
        InvalidInput: the file is no model, lacks the keyframe, or the run would be too short or too long.
    """
    # By its whole path, as in the lines: MuJoCo keeps in the model where its assets are.
    model = load_model(path.absolute())
    with user_model_errors(path):
        check_finite(model)
        steps, every = run_steps(model, seconds)
        closures = hardenable_closures(model) if force else active_closures(model)
        notes = recipes.hardening_notes(model, closures)
        found = HardenedModel(str(path), mujoco.__version__, warnings=notes)
        if reason := recipes.refusal_reason(model, closures):
            forced = f"; {FORCE}" if handle_indices(model) and not closures else ""
            return replace(found, refusals=(f"{reason}{forced}",))
        soft = recipes.soft_on_purpose(model, closures)
        if soft and not force:
            return replace(found, refusals=tuple(f"{reason}; {FORCE}" for reason in soft))
        in_metres = copy.copy(model)
        convert_to_metres(in_metres, unit)
        controls = controls_in_metres(in_metres, controls, unit)
        recipe, (state, start) = recipes.recipe_for(model, closures), closed_start(in_metres, keyframe, controls)
        found = replace(
            found,
            loops=tuple(f"{one.kind} {one.name}" for one in closures),
            factor=recipe[0].value,
            lines=recipes.python_lines(recipe, path.absolute()),
            **start,
            **compare_runs(
                in_metres, apply_recipe(in_metres, recipe), state, steps, every, [one.index for one in closures]
            ),
        )
    harm = _harm_reason(found, *found.variants)
    refused = bool(harm) and not force
    return replace(
        found,
        refusals=(f"{harm}; {FORCE}",) if refused else (),
        warnings=(*soft, *([harm] if harm and not refused else ()), *_doubts(found), *notes, *_acting_words(found)),
        content=None if refused or not content else _binary_model(apply_recipe(model, recipe)),
    )


def compare_runs(
    model: mujoco.MjModel, hard: mujoco.MjModel, state: Array, steps: int, every: int, closures: list[int]
) -> dict[str, Any]:
    """Run a model as it is and hardened; return these fields of a `HardenedModel`."""
    size, timestep = float(model.stat.extent), float(model.opt.timestep)
    runs = [run_finer(one, state, steps, every) for one in (model, hard)]
    reference = reference_motion(hard, runs[1], state, steps, every)

    def variant(name: str, made: Run) -> HardeningRun:
        completed = every * (len(made.states) - 1)
        if made.broke:
            return HardeningRun(name, completed, made.broke)
        drift = None if reference.known_to is None else _largest_distance(made.centres, reference.centres)
        return HardeningRun(
            name, completed, "", tuple(made.constraint_violations(size)[:, closures].max(axis=0).tolist()), drift
        )

    before, after = variant("as it is", runs[0]), variant("hardened", runs[1])
    steppers = (looping_stepper(without_autoreset(one), state, steps) for one in (hard, model))
    return {
        "size": size,
        "timestep": timestep,
        "seconds": timestep * steps,
        "variants": (before, after),
        "travel": None if reference.broke else _largest_distance(reference.centres, reference.centres[0]),
        "reference_known_to": reference.known_to,
        "reference_extrapolated": reference.extrapolated,
        "acting": merge_forces(force for made in runs for force in made.acting),
        "cost": None if before.broke or after.broke else time_stepper_pair(*steppers),
    }


def _binary_model(model: mujoco.MjModel) -> bytes:
    """The model as MuJoCo saves it (mj_saveModel)."""
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


def _harm_reason(found: HardenedModel, before: HardeningRun, after: HardeningRun) -> str:
    """Why the hardened model is worse than the model as it is; empty if it is not."""
    if after.broke:
        hardened = f"the run breaks off hardened after {after.steps} steps ({after.broke}), and as it is"
        if before.broke:
            return f"{hardened} after {before.steps} ({before.broke}): nothing shows what hardening does"
        return f"{hardened} it does not: {ADVICE}"
    then, now = (max(one.openings or (), default=0.0) for one in (before, after))
    if not before.broke and now > max(WORSE_FACTOR * then, CLOSED_SHARE * found.size):
        return f"its loops open more, {1e3 * now:.1e} mm and as it is {1e3 * then:.1e} mm: {ADVICE}"
    return ""


def _acting_words(found: HardenedModel) -> tuple[str, ...]:
    """Sentences on forces other than the loops' that act in these runs."""
    return acting_sentences((one for one in found.acting if one.kind != LACKING), run="in these runs", judged=False)


def _doubts(found: HardenedModel) -> Iterator[str]:
    """Yield reasons to doubt the figures."""
    if not found.start_closed:
        yield "no pose near the start closes the loops: the runs start with them open"
    if found.travel is not None and found.travel < STANDSTILL_SHARE * found.size:
        yield (
            f"nothing moves in these runs (travel {found.travel:.1e} m): they show how far the loops open at rest, "
            "and nothing else; --keyframe KEY starts others, --ctrl NAME=VALUE commands a motion"
        )


# -- runs -------------------------------------------------------------------------------------------------------------


def closed_start(
    model: mujoco.MjModel, keyframe: str | None = None, controls: Controls = ()
) -> tuple[Array, dict[str, Any]]:
    """Return the requested start, or the first keyframe, with its loops closed where possible.

    Its rates then become the nearest ones that open no loop.

    Returns:
        The state, and the fields of a `HardenedModel` that describe it.

    Raises:
        InvalidInput: the model has no such keyframe or actuator.
    """
    data, index = data_at_start(model, keyframe, controls)
    mujoco.mj_fwdPosition(model, data)
    given = float(constraint_violations(model, data, float(model.stat.extent)).max(initial=0.0))
    state, name = state_of(model, data), start_words(model, index, data.ctrl)
    closed = close_loops(model, data, CLOSING_TOLERANCE * float(model.stat.extent))
    if closed:
        jacobian = equality_jacobian(model, data)
        data.qvel[:] -= np.linalg.lstsq(jacobian, jacobian @ data.qvel, rcond=REDUNDANT_ROW_SHARE)[0]
        state = state_of(model, data)
    return state, {"start": name, "start_opening": given, "start_closed": closed}


def run_finer(
    model: mujoco.MjModel, state: Array, steps: int, every: int, refinement: int = 1, *, watched: bool = True
) -> Run:
    """Run a model from a state with `refinement` times as many steps between the same samples."""
    made = without_autoreset(model)
    set_step(made, float(made.opt.timestep) / refinement)
    return run(made, state, steps * refinement, every * refinement, watched=watched)


def without_autoreset(model: mujoco.MjModel) -> mujoco.MjModel:
    """A copy of a model that does not reset itself when its run breaks off."""
    made = copy.copy(model)
    made.opt.disableflags |= compat.disable_bit("AUTORESET")
    return made


def _largest_distance(points: Array, others: Array) -> float:
    """The largest distance of a body from other points [m]."""
    return float(np.linalg.norm(points - others, axis=2).max(initial=0.0))


def run_steps(model: mujoco.MjModel, seconds: float | None = None) -> tuple[int, int]:
    """Number of steps of a run, and of steps from one sample to the next.

    Raises:
        InvalidInput: the steps are too few or too many.
    """
    timestep = float(model.opt.timestep)
    least, most = MIN_STEPS * timestep, MAX_STEPS * timestep
    seconds = min(max(USUAL_SECONDS, least), most) if seconds is None else seconds
    if not least <= seconds <= most:
        raise InvalidInput(
            f"--seconds {seconds:g} is out of range: {least:.3g} to {most:.3g} at the model's step of {timestep:g} s"
        )
    steps = math.ceil(seconds / timestep - 1e-9)
    every = math.ceil(steps / MAX_SAMPLES)
    return math.ceil(steps / every) * every, every


class ReferenceMotion(NamedTuple):
    """Motion of the machine with closed loops, that runs are compared with.

    Attributes:
        centres: centres of gravity (T, n, 3) [m].
        known_to: error [m] of them; None if a run broke off.
        broke: whether the run of the motion itself broke off.
        extrapolated: whether it is extrapolated to a step of zero, from `EXTRAPOLATED_REFINEMENTS`.
    """

    centres: Array
    known_to: float | None
    broke: bool = False
    extrapolated: bool = False


def reference_motion(hard: mujoco.MjModel, first: Run, state: Array, steps: int, every: int) -> ReferenceMotion:
    """Return the motion of the hardened model under RK4 in the limit of a step of zero, estimated from runs.

    What a soft loop adds to the motion is thus an error, as it is for the user.

    Args:
        first: the hardened model's run at its own step.
    """
    rounding = float(np.finfo(float).eps) * float(hard.stat.extent)
    if not first.broke and (found := _extrapolated_motion(hard, first, state, steps, every, rounding)) is not None:
        return found
    fine, check = (
        run_finer(hard, state, steps, every, times, watched=False) for times in (REFERENCE_REFINEMENT, CHECK_REFINEMENT)
    )
    known = None if fine.broke or check.broke else max(_largest_distance(fine.centres, check.centres), rounding)
    return ReferenceMotion(fine.centres, known, broke=bool(fine.broke))


def _extrapolated_motion(
    hard: mujoco.MjModel, first: Run, state: Array, steps: int, every: int, rounding: float
) -> ReferenceMotion | None:
    """Extrapolate the motion from runs at the step, its half and its quarter; None where RK4 does not have its order.

    Of x(h) = x + a h^4 + b h^5 + .. the first extrapolation, (16 x(h/2) - x(h)) / 15, leaves an error of order 5, and
    the second, (32 y(h/2) - y(h)) / 31 of its values y, of order 6 (Richardson; Hairer, Norsett and Wanner, Solving
    Ordinary Differential Equations I, section II.9). The error stated is the difference of the first ones, which has
    what rounding left in them too.
    """
    whole, half = first.centres, run_finer(hard, state, steps, every, EXTRAPOLATED_REFINEMENTS[1], watched=False)
    if half.broke:
        return None
    quarter = run_finer(hard, state, steps, every, EXTRAPOLATED_REFINEMENTS[2], watched=False)
    if quarter.broke:
        return None
    coarse, fine = _largest_distance(whole, half.centres), _largest_distance(half.centres, quarter.centres)
    if coarse > rounding and not MIN_DIFFERENCE_RATIO * fine <= coarse <= MAX_DIFFERENCE_RATIO * fine:
        return None
    before, after = (
        one + (one - other) / 15.0 for one, other in ((half.centres, whole), (quarter.centres, half.centres))
    )
    found = after + (after - before) / 31.0
    return ReferenceMotion(found, max(_largest_distance(after, before), rounding), extrapolated=True)
