"""Qualification of a check of a user's model: which known defects of the model it would notice, and from what size on.

A right model against a machine with a rod that is longer is as far off as a wrong model against the right machine, so
defects of lengths need no other model: the paths that were scanned are identified once more. Masses are changed in a
copy of the compiled model, which is run again.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from conrod.comparison.trajectory import Outcome
from conrod.errors import InvalidInput
from conrod.mjcf.loop_results import OWN_SETTINGS
from conrod.mjcf.request import Scan
from conrod.models.check.frame import GivenFrame
from conrod.models.check.identity import is_machine
from conrod.models.check.references import ALL_LENGTHS, length_names, with_lengths
from conrod.models.check.results import ModelStudy
from conrod.studies.validation.results import DefectVerdict, Qualification

if TYPE_CHECKING:
    from conrod.models.check.study import ModelBench

PERCENT, MASS = "%", "mass"
# Sizes that are planted, and the largest that are tried, as shares.
LENGTH_SIZE, MAX_LENGTH_SIZE = 1e-4, 0.1
MASS_SIZE, MAX_MASS_SIZE = 1e-2, 0.9
SPEED_SIZE, MAX_SPEED_SIZE = 0.05, 0.5

Failures = Callable[[float], tuple[str, ...]]  # what is out of tolerance with a defect of a size; empty if nothing is


def qualify_check(found: ModelStudy, scanned: Scan, given: GivenFrame, bench: ModelBench) -> Qualification:
    """Plant defects of length, mass and speed into a passed check; return the smallest it detects."""
    kinds = {
        "length": (LENGTH_SIZE, MAX_LENGTH_SIZE, _length_places(found, scanned, given)),
        MASS: (MASS_SIZE, MAX_MASS_SIZE, _mass_places(found, bench)),
        "speed of its own run": (SPEED_SIZE, MAX_SPEED_SIZE, _speed_places(found)),
    }
    verdicts = []
    for kind, (size, largest, places) in kinds.items():
        each = [_examine(kind, where, failures, size, largest) for where, failures in places]
        if each:  # of several places the one counts at which least is noticed
            verdicts.append(max(each, key=lambda one: (not one.by, one.smallest or np.inf)))
    return Qualification(tuple(verdicts), ())


def _examine(kind: str, where: str, failures: Failures, size: float, largest: float) -> DefectVerdict:
    """Plant a defect at one place, and search for the smallest size of either sign that is noticed."""
    from conrod.studies.detection.qualification import smallest_noticed_size

    smallest = smallest_noticed_size(lambda share: bool(failures(share)), largest)
    if smallest is not None and not failures(-smallest):
        smallest = smallest_noticed_size(lambda share: bool(failures(-share)), largest)
    # A driven crank moves the same whatever the masses: what no size of these shows cannot be seen.
    visible = smallest is not None or kind != MASS
    return DefectVerdict(kind, PERCENT, where, size, failures(size), smallest, visible)


def _length_places(found: ModelStudy, scanned: Scan, given: GivenFrame) -> Iterator[tuple[str, Failures]]:
    """Yield each length with what its change makes of the model's identity."""
    scene = found.scene

    def failures(name: str, share: float) -> tuple[str, ...]:
        try:
            other = with_lengths(scene, [name], np.array([(1.0 + share) * scene.parameters[name]]))
            right = is_machine(other, scanned, given, found.kinematic_tolerance)
        except InvalidInput:
            return ("cannot be put together",)
        return () if right else ("paths",)

    for name in length_names(scene):
        if name != ALL_LENGTHS and scene.parameters[name]:
            yield name, partial(failures, name)


def _mass_places(found: ModelStudy, bench: ModelBench) -> Iterator[tuple[str, Failures]]:
    """Yield each body that has a mass with what its change makes of the run with the model's own settings."""
    model = bench.turning.model

    def failures(body: int, share: float) -> tuple[str, ...]:
        edited = copy.copy(model)
        edited.body_mass[body] *= 1.0 + share
        edited.body_inertia[body] *= 1.0 + share
        mujoco.mj_setConst(edited, mujoco.MjData(edited))
        run = replace(bench, turning=replace(bench.turning, model=edited)).run_driven(OWN_SETTINGS)
        if run.outcome is not Outcome.COMPLETED:
            return (run.outcome.slug,)
        return tuple(replace(found, runs={**found.runs, OWN_SETTINGS: run}).exceeded_limits(run))

    for body in np.flatnonzero((model.body_weldid > 0) & (model.body_mass > 0.0)).tolist():
        yield model.body(body).name or f"body {body}", partial(failures, body)


def _speed_places(found: ModelStudy) -> Iterator[tuple[str, Failures]]:
    """Yield the crank's speed with what another one makes of the file's own run, where that starts a motion."""
    if not found.has_start or found.crank is None:
        return

    def failures(share: float) -> tuple[str, ...]:
        other = found.scene.with_parameters(speed=(1.0 + share) * found.scene.speed)
        return ("speed",) if replace(found, scene=other).strays else ()

    yield "", failures
