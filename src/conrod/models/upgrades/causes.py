"""Why a model moves otherwise in a release: compiled numbers, a term of the equations of motion, or rounding."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from conrod.exact.motion import Array
from conrod.models.upgrades.release_calls import advance_states, run_model, states_between, terms_at
from conrod.models.upgrades.results import COMPILED, PARTED_SHARE, ROUNDING, TERM, ModelRun, ReleaseRun, StepTerms
from conrod.report.numbers import measured_text

# Calls a function of `release_calls` in the process of a release.
Call = Callable[..., Any]
# Compiled numbers that differ by less are rounded otherwise.
COMPILED_TOLERANCE = 1e-9
COMPUTED_ENDINGS = (
    "mass", "inertia", "ipos", "iquat", "invweight0", "_M0", "length0", "_acc0", "lengthrange", "_sameframe", "_simple",
)  # fmt: skip
# Between two samples a term has jumped where the releases part by this many times what one bit grows to there, and by
# more than a solver that stops by its tolerance may leave.
JUMP_FACTOR, MIN_JUMP = 1e4, 1e-9
FORCE_NAMES = {
    "qfrc_bias": "gravity and inertia",
    "qfrc_passive": "springs, dampers and fluid",
    "qfrc_actuator": "actuators",
    "qfrc_constraint": "constraints",
}
MAX_NAMED = 3


def cause_of_change(request: ModelRun, before: ReleaseRun, after: ReleaseRun, old: Call, new: Call) -> tuple[str, str]:
    """Find the kind of cause of a change between two releases, and say it in words.

    Both releases start from the same states, those of the older one: what they make of them over some steps differs
    by what the release changed, and not by how far the motions have parted before.

    Args:
        before, after: the run in the older and in the newer release.
        old, new: call a function in the process of the older and of the newer release.
    """
    compiled = compiled_differences(before, after)
    model = f"the compiled model is another one: {'; '.join(compiled)}" if compiled else ""
    if before.bodies.shape[1:] != after.bodies.shape[1:]:
        return COMPILED, model or "the compiled model has other bodies"
    samples = before.samples - 1
    starts = {name: rows[:samples] for name, rows in before.states.items()}
    reached = [call(advance_states, request, starts, before.every) for call in (old, new)]
    one_bit = old(advance_states, request, starts, before.every, True)
    local, growth = (relative_differences(reached[0], other) for other in (reached[1], one_bit))
    jumps = np.flatnonzero(local > np.maximum(JUMP_FACTOR * growth, MIN_JUMP))
    if not jumps.size:
        equal = "from equal states both releases make equal steps"
        return (COMPILED, f"{model}; yet {equal}") if compiled else (ROUNDING, equal)
    # At rest a force such as damping is nothing yet: it is looked for where the releases differ most, too.
    places = dict.fromkeys([int(jumps[0]), *map(int, jumps[1:2]), int(jumps[np.argmax(local[jumps])])])
    named = [words for at in places if (words := jump_words(request, before, at, old, new))]
    words = named[0] if named else step_words(before, int(jumps[0]))
    share = f"; so in {jumps.size} of {samples} stretches from equal states" if jumps.size > 1 else ""
    return (COMPILED, f"{model}; {words}{share}") if compiled else (TERM, f"{words}{share}")


def relative_differences(one: Array, other: Array) -> Array:
    """Largest difference in each row (T, n), relative to the row's largest number if that exceeds 1."""
    scale = np.maximum(1.0, np.abs(one).max(axis=1, initial=0.0))
    return np.asarray(np.nan_to_num(np.abs(other - one).max(axis=1, initial=0.0) / scale, nan=np.inf))


def compiled_differences(before: ReleaseRun, after: ReleaseRun) -> list[str]:
    """Fields of the compiled model that differ by more than rounding, each with the element that differs most."""
    found = []
    # What the compiler computes from other fields comes after them.
    for name, one in sorted(before.fields.items(), key=lambda field: field[0].endswith(COMPUTED_ENDINGS)):
        other = after.fields.get(name)
        if other is None or (one.shape != other.shape and one.ndim != other.ndim):
            continue  # a field that one release does not have, or lays out otherwise
        if one.shape != other.shape:
            if one.shape[1:] == other.shape[1:]:
                found.append(f"{name} has {len(other)} rows, had {len(one)}")
            continue
        off = np.abs(other - one) / np.maximum(np.maximum(np.abs(one), np.abs(other)), 1e-12)
        if off.size and off.max() > COMPILED_TOLERANCE:
            where = np.unravel_index(int(np.argmax(off)), off.shape)
            element = _element_name(before, name, int(where[0]))
            found.append(f"{name}{element} is {other[where]:.6g}, was {one[where]:.6g}")
    rest = len(found) - MAX_NAMED
    return [*found[:MAX_NAMED], *([f"and {rest} more fields"] if rest > 0 else [])]


def _element_name(run: ReleaseRun, field: str, row: int) -> str:
    kind = {"jnt": "joint", "eq": "equality"}.get(field.partition("_")[0], field.partition("_")[0])
    names = run.names.get(kind, ())
    return f" of {names[row]}" if row < len(names) and len(names) == len(run.fields[field]) else ""


def chaos_words(request: ModelRun, before: ReleaseRun, old: Call) -> str:
    """Say how far the older release's run moves if its start changes by one bit."""
    other = old(run_model, request, True)
    count = min(before.samples, other.samples)
    share = np.linalg.norm(other.bodies[:count] - before.bodies[:count], axis=2).max(axis=1) / before.extent
    if (largest := float(share.max(initial=0.0))) <= PARTED_SHARE:
        return "yet the older one's own motion hardly depends on a bit at its start"
    return (
        "the motion is chaotic: the older release itself parts as well from a start one bit off, by "
        f"{measured_text(largest)} of the model's size"
    )


def step_words(before: ReleaseRun, sample: int) -> str:
    """Say that all forces agree at a sample, and the integrator's next state does not."""
    stages = ", in its further stages" if before.options["integrator"] == "RK4" else ""
    integrator = before.options["integrator"]
    return (
        f"all forces agree at the begin of a step, and what {integrator} makes of them{stages} does not, from "
        f"{before.time_of(sample):.4g} s on"
    )


def jump_words(request: ModelRun, before: ReleaseRun, sample: int, old: Call, new: Call) -> str:
    """Name the first term that differs from equal states in the steps after a sample, and when; empty if none does."""
    state = {name: rows[sample] for name, rows in before.states.items()}
    states = old(states_between, request, state, before.every)
    terms = zip(*(call(terms_at, request, states) for call in (old, new)), strict=True)
    for step, (one, other) in enumerate(terms):
        if words := term_words(before.names, one, other):
            return f"{words} at {before.time_of(sample) + step * before.timestep:.4g} s"
    return ""


def term_words(names: Mapping[str, tuple[str, ...]], before: StepTerms, after: StepTerms) -> str:
    """Name the first term that differs at a state: contacts, then forces as they are computed; empty if none does."""
    pairs = [sorted((a, b) for a, b, _ in one.contacts) for one in (before, after)]
    if pairs[0] != pairs[1]:
        a, b = next(iter(set(pairs[0]) ^ set(pairs[1])), (pairs[1] or pairs[0])[0])
        between = f"{names['geom'][a]} and {names['geom'][b]}"
        return f"contacts change, {len(pairs[0])} before, now {len(pairs[1])} (between {between})"
    depths = [
        abs(one[2] - other[2]) for one, other in zip(sorted(before.contacts), sorted(after.contacts), strict=True)
    ]
    if depths and max(depths) > MIN_JUMP:
        a, b, _ = sorted(before.contacts)[int(np.argmax(depths))]
        between = f"{names['geom'][a]} and {names['geom'][b]}"
        return f"the contact between {between} is {measured_text(1e3 * max(depths))} mm deeper or shallower"
    scale = max(1.0, *(float(np.abs(force).max(initial=0.0)) for force in before.forces.values()))
    off = {name: np.abs(after.forces[name] - force) for name, force in before.forces.items()}
    sizes = {name: float(size.max(initial=0.0)) for name, size in off.items()}
    largest = max(sizes.values())
    if largest > MIN_JUMP * scale:
        # Constraint forces answer all others: the first that differs is the cause.
        name = next(name for name, size in sizes.items() if size > 1e-3 * largest)
        dof = int(np.argmax(off[name]))
        joint, was, now = names["dof"][dof], before.forces[name][dof], after.forces[name][dof]
        return f"the force of {FORCE_NAMES[name]} at {joint} changes, {was:.4g} before, now {now:.4g} N or N m,"
    return ""
