"""A model's own run in several releases of MuJoCo, and what changed from each to the next."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from conrod.engines.releases import Releases
from conrod.errors import InvalidInput
from conrod.execution.paired_timing import Block, PairedTiming, time_block_pair
from conrod.execution.releases import ReleaseProcesses
from conrod.execution.worker_process import WorkerDied
from conrod.models.upgrades.causes import cause_of_change, chaos_words
from conrod.models.upgrades.release_calls import (
    advance_model_stepper,
    prepare_model_stepper,
    run_model,
    start_in_words,
    steps_of,
)
from conrod.models.upgrades.results import (
    COMPILED,
    PARTED_SHARE,
    REFUSED,
    ROUNDING,
    ModelChange,
    ModelCost,
    ModelRun,
    ReleaseRun,
    UpgradeStudy,
)

# Calls a function of `release_calls` in a process of a release; the number is that of the process.
CallRelease = Callable[..., Any]
COMPLETED = "completed"


def call_release(
    processes: ReleaseProcesses, version: str, process: int, function: Callable[..., Any], *arguments: Any
) -> Any:
    """Call a function in a process of a release, and return its result.

    Raises:
        InvalidInput: the release cannot be installed, refuses the model, ends or takes too long; says which.
    """
    try:
        return processes.call(version, process, function, *arguments)
    except WorkerDied as error:
        raise InvalidInput(f"it {error}") from None
    except TimeoutError as error:
        raise InvalidInput(str(error)) from None
    except (AttributeError, TypeError) as error:
        # A release lacks something that conrod uses of it.
        raise InvalidInput(f"conrod cannot drive it: {type(error).__name__}: {error}") from None


def upgrade_study(
    file: str, request: ModelRun, versions: Sequence[str], releases: Releases, call: CallRelease
) -> UpgradeStudy:
    """Run a model in each release, and return the changes from one release to the next.

    Args:
        file: what the model is called.
        versions: releases, the oldest first.
        releases: how each is installed, and what its changelog says.
        call: calls `function(request, ...)` as `call(version, process, function, ...)`; raises InvalidInput where the
            release cannot be had, or refuses the model.

    Raises:
        InvalidInput: no release runs the model; says why the last one does not.
    """
    runs, refused = dict[str, ReleaseRun](), dict[str, str]()
    for version in versions:
        try:
            runs[version] = call(version, 0, run_model, request)
        except InvalidInput as error:
            refused[version] = str(error)
    if not runs:
        raise InvalidInput(f"mujoco {versions[-1]}: {refused[versions[-1]]}")
    last = next(reversed(runs))
    changes = [_change(request, earlier, later, runs, releases, call) for earlier, later in pairwise(runs)]
    # A release that refuses a model which the one before it ran is a change, and the first to act on.
    changes += [
        ModelChange(version, before, REFUSED, refused[version], (COMPLETED, "refused"))
        for before, version in pairwise(versions)
        if before in runs and version in refused
    ]
    return UpgradeStudy(
        file, call(last, 0, start_in_words, request), request.seconds, steps_of(request, runs[last].timestep),
        runs[last].extent, tuple(runs), refused,
        tuple(sorted((one for one in changes if one), key=lambda one: versions.index(one.version))), releases.source,
    )  # fmt: skip


def _change(
    request: ModelRun, earlier: str, later: str, runs: dict[str, ReleaseRun], releases: Releases, call: CallRelease
) -> ModelChange | None:
    """The change from one release to the next; None if all samples agree to the last bit."""
    before, after = runs[earlier], runs[later]
    found = motion_change(before, after)
    if found is None:
        return None
    old, new = partial(call, earlier, 0), partial(call, later, 0)
    kind, cause = cause_of_change(request, before, after, old, new)
    if kind == ROUNDING and not found.last_digits:
        cause = f"{cause}; {chaos_words(request, before, old)}"
    contact = {False, max(before.contacts, after.contacts) > 0}
    words = tuple(
        fact.words
        for fact in releases.facts
        if fact.version == later
        and (kind == ROUNDING or not fact.rounding)
        and any(fact.concerns(one, after.options) for one in contact)
    )
    return replace(found, version=later, before=earlier, kind=kind, cause=cause, explained=words)


def motion_change(before: ReleaseRun, after: ReleaseRun) -> ModelChange | None:
    """How far two runs are apart, and since when; None if all samples agree to the last bit."""
    ended = before.broke or COMPLETED, after.broke or COMPLETED
    if before.bodies.shape[1:] != after.bodies.shape[1:]:
        return ModelChange("", "", COMPILED, "", ended)
    count = min(before.samples, after.samples)
    states = [np.hstack([run.states[name][:count] for name in ("qpos", "qvel")]) for run in (before, after)]
    differs = np.flatnonzero((states[0] != states[1]).any(axis=1))
    if not differs.size and ended[0] == ended[1]:
        return None
    apart = np.linalg.norm(after.bodies[:count] - before.bodies[:count], axis=2)
    apart = np.nan_to_num(apart, nan=0.0)
    sample, body = np.unravel_index(int(np.argmax(apart)), apart.shape)
    parted = np.flatnonzero(apart.max(axis=1) > PARTED_SHARE * before.extent)
    moved = float(apart[sample, body])
    return ModelChange(
        "", "", "", "", ended,
        moved=moved,
        share=moved / before.extent,
        body=before.names["body"][int(body)],
        at=before.time_of(int(sample)),
        differs_at=before.time_of(int(differs[0])) if differs.size else None,
        parted_at=before.time_of(int(parted[0])) if parted.size else None,
    )  # fmt: skip


# -- costs -------------------------------------------------------------------------------------------------------------


def model_costs(study: UpgradeStudy, request: ModelRun, reference: str, call: CallRelease) -> tuple[ModelCost, ...]:
    """Time a step in each release against a reference release, alternating between two processes."""

    def block(version: str, process: int) -> Block:
        call(version, process, prepare_model_stepper, request)
        return partial(call, version, process, advance_model_stepper)

    def time(version: str) -> PairedTiming:
        return time_block_pair(lambda: (block(version, 0), block(reference, 1)))

    noise, found = None, list[ModelCost]()
    for version in study.measured:
        if version == reference:
            continue
        try:
            noise = noise or time(reference)
            found.append(ModelCost(version, time(version), noise))
        except InvalidInput as error:
            found.append(ModelCost(version, None, None, str(error)))
    return tuple(found)
