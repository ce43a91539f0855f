"""A model as it is, with its weights scaled alone, and hardened: the same run of each, at three steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import takewhile

import mujoco
import numpy as np

from conrod.exact.motion import Array
from conrod.mjcf.harden.closures import Closure
from conrod.mjcf.harden.recipe import Recipe, edited
from conrod.mjcf.harden.results import HardenedModel, Orders, Variant
from conrod.mjcf.harden.runs import CLOSED, Pace, Swing, conservative, energy_drift, paced, swing
from conrod.mjcf.runs import looping_stepper
from conrod.runs.convergence import observed_order
from conrod.studies.frame.paired_timing import PairedCost, paired_cost

AS_IT_IS, WEIGHTS_ALONE, HARDENED = "as it is", "weights alone", "hardened"
LEVELS = (1, 2, 4)
# Under RK4 a sixteenth of the step leaves 1/65536 of the error; an eighth shows how well that is known.
REFERENCE, CHECK = 16, 8
# An error of less than this many times what the reference is known to says nothing about its order.
RESOLVED = 3.0
# A machine whose bodies move by less than this share of its size stands.
STANDS = 1e-9


def measured(
    found: HardenedModel,
    model: mujoco.MjModel,
    closures: Sequence[Closure],
    recipe: Recipe,
    state: Array,
    pace: Pace,
) -> HardenedModel:
    """Findings with the figures of a model, run in three ways.

    The reference, which is the same for all three, is the hardened model under RK4 at a sixteenth of the step: the
    machine with its loops closed. What a soft loop adds to the motion is thus an error, as it is for the user.
    """
    precise = edited(model, replace(recipe, integrator="RK4"))
    reference, check = (swing(precise, state, pace.finer(times), closures) for times in (REFERENCE, CHECK))
    known, travel = None, None
    if not reference.broke:
        travel = float(np.linalg.norm(reference.points - reference.points[0], axis=2).max())
        if not check.broke:
            known = max(distance(reference, check), float(np.finfo(float).eps) * found.size)
    standing = stands(travel, found.size)
    bare, without = conservative(model)
    variants, note = list[Variant](), "nothing moves" if standing else ""
    for name, edit in ((AS_IT_IS, None), (WEIGHTS_ALONE, recipe.weights_alone), (HARDENED, recipe)):
        changed = edited(model, edit)
        runs = [swing(changed, state, pace.finer(times), closures) for times in LEVELS]
        energy, reason = energy_drift(edited(bare, edit), state, pace)
        note = note or reason
        variants.append(replace(_variant(name, found, runs, reference, known, standing), energy=energy))
    if note:
        variants = [replace(variant, energy=None) for variant in variants]
    return replace(
        found,
        variants=tuple(variants),
        travel=travel,
        reference_known_to=known,
        energy_without=without,
        energy_note=note,
    )


def stands(travel: float | None, size: float) -> bool:
    """True for a machine of a size [m] that hardly moves."""
    return travel is not None and travel < STANDS * size


def distance(one: Swing, other: Swing) -> float:
    """The largest distance of a body in one run from where it is in another [m]."""
    return float(np.linalg.norm(one.points - other.points, axis=2).max(initial=0.0))


def cost(model: mujoco.MjModel, recipe: Recipe, state: Array, pace: Pace) -> PairedCost:
    """Cost of a hardened step over one as it is, both through the same motion, again and again from its start."""
    soft, hard = (
        looping_stepper(paced(edited(model, edit), pace), state, pace.samples * pace.stride) for edit in (None, recipe)
    )
    return paired_cost(hard, soft)


def _variant(
    name: str, found: HardenedModel, runs: Sequence[Swing], reference: Swing, known: float | None, standing: bool
) -> Variant:
    """Figures of runs at the model's step, a half and a quarter of it."""
    own = runs[0]
    if own.broke:
        return Variant(name, own.steps, own.broke)
    unit = "m" if any(loop.unit == "m" for loop in found.loops) else "rad"
    widest = [float(run.openings[:, [loop.unit == unit for loop in found.loops]].max()) for run in runs]
    closing = drift = None
    if not any(run.broke for run in runs):
        closing = _orders(widest, CLOSED * (found.size if unit == "m" else 1.0), standing)
        if known is not None:
            drift = _orders([distance(run, reference) for run in runs], RESOLVED * known, standing)
    return Variant(
        name,
        own.steps,
        openings=tuple(float(value) for value in own.openings.max(axis=0)),
        opening_over_size=widest[0] / found.size if unit == "m" else None,
        closing=closing,
        drift=drift,
        touching=own.touching,
        iterations=own.iterations,
    )


def _orders(values: Sequence[float], least: float, standing: bool) -> Orders:
    """Orders of values at three steps, those down to `least` alone; none of a machine that stands."""
    order = observed_order(LEVELS, values)
    resolved = 0 if standing else sum(1 for _ in takewhile(lambda value: value > least, values))
    pairs = tuple(pair if k + 1 < resolved else None for k, pair in enumerate(order.pairs))
    return Orders(tuple(values), order.claimed if resolved == len(values) else None, pairs)
