"""Measured changelog of an engine: the same runs in each of its releases, and where something changed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from conrod.engines import Engine
from conrod.engines.capabilities import KnownReleases, require_capability
from conrod.engines.engine import run_extent
from conrod.errors import InvalidInput
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.frame.case import QUANTITIES, Measurement
from conrod.studies.frame.reference_guard import ReferenceGuard
from conrod.studies.releases import VersionCase

# A change of a normalised position up to this is of last digits; so is one of a velocity or an acceleration that such
# a one makes when it is differentiated over a step.
LAST_DIGITS = 1e-12


@dataclass(frozen=True)
class Change:
    """A change of a run from one release to the next one that was run.

    Attributes:
        version, before: the release with the change, and the one before.
        outcomes, errors: before and after; the largest position error, normalised, or None unless it completed.
        differ: names of the states and outputs that are not the same to the last bit.
        size: by quantity, the largest difference of the two motions at twenty angles of the last turn, normalised as
            errors are; empty unless both completed.
        last_digits: whether nothing but these changed; True also where the size of other bits is not known.
        explained: what the engine's own changelog says of the release that can be the cause; empty where nothing is.
    """

    version: str
    before: str
    outcomes: tuple[str, str]
    errors: tuple[float | None, float | None]
    differ: tuple[str, ...]
    size: Mapping[str, float]
    last_digits: bool
    explained: tuple[str, ...] = ()


@dataclass(frozen=True)
class History:
    """A scene with some settings through the releases.

    Attributes:
        changes: where a run is not that of the release before, to the last bit.
    """

    scene: str
    settings: str
    steps_per_revolution: int
    changes: tuple[Change, ...]

    def change_at(self, version: str) -> Change | None:
        """The change of a release; None where it is the same as the one before to the last bit."""
        return next((change for change in self.changes if change.version == version), None)


@dataclass(frozen=True)
class VersionStudy:
    """Releases of an engine on the same runs.

    Attributes:
        source: where the engine's own changelog is.
        measured: versions that could be had, the oldest first.
        unsupported: why others could not.
        distrust: scenes and engines whose figures cannot be trusted, and why, in words; empty if there are none.
    """

    engine: str
    source: str
    measured: tuple[str, ...]
    unsupported: Mapping[str, str]
    histories: tuple[History, ...]
    distrust: str = ""

    def changes_at(self, version: str) -> tuple[tuple[History, Change], ...]:
        """Changes that a release brought."""
        return tuple((one, change) for one in self.histories if (change := one.change_at(version)) is not None)


LINKAGE_STEPS, CONTACT_STEPS, REVOLUTIONS = 1000, 8000, 2.0  # steps per revolution
Runs = Mapping[str, Measurement]


def plan_cases(scenes: Mapping[str, Scene], engine: Engine[Any]) -> dict[tuple[str, str], VersionCase]:
    """All that is run in each release of an engine, by scene and by name of the settings; cases of no release yet.

    Raises:
        InvalidInput: the engine has no list of its releases.
    """
    made = require_capability(engine, KnownReleases)
    found = {}
    for name, scene in scenes.items():
        steps = CONTACT_STEPS if scene.kinematics.mechanism.cam_contacts else LINKAGE_STEPS
        start, turns = run_extent(scene, steps, REVOLUTIONS)
        for label, settings in made.probes(scene, steps).items():
            found[name, label] = VersionCase(name, scene, settings, turns, start, version="")
    return found


def versions_study(
    engine: Engine[Any],
    versions: Sequence[str],
    cases: Mapping[tuple[str, str], VersionCase],
    perform: Callable[[str, Sequence[VersionCase]], Runs],
) -> VersionStudy:
    """Findings on releases of an engine, the oldest first; a release that cannot be had is unsupported, others go on.

    Args:
        perform: given what is to be installed and the cases of a release, its measurements by key; InvalidInput where
            it cannot be had.

    Raises:
        InvalidInput: none of them can be had; says why of the last.
    """
    releases, runs, unsupported = (
        require_capability(engine, KnownReleases).releases,
        dict[str, Runs](),
        dict[str, str](),
    )
    guard = ReferenceGuard()
    for version in versions:
        try:
            asked = [replace(case, version=version) for case in cases.values()]
            runs[version] = perform(releases.requirement(version), asked)
            guard.check(asked, runs[version])
        except InvalidInput as error:
            unsupported[version] = str(error)
            if len(unsupported) == len(versions):
                raise InvalidInput(f"{engine.name} {version}: {error}") from None
    histories = tuple(
        History(
            scene=scene,
            settings=settings,
            steps_per_revolution=case.settings.steps_per_revolution,
            changes=tuple(_changes(case, runs, releases.matching_entries)),
        )
        for (scene, settings), case in cases.items()
    )
    return VersionStudy(engine.name, releases.source, tuple(runs), unsupported, histories, guard.distrust)


def _changes(case: VersionCase, runs: Mapping[str, Runs], named: Callable[..., tuple[str, ...]]) -> Iterable[Change]:
    for earlier, later in pairwise(runs):
        before, after = (runs[version][replace(case, version=version).key] for version in (earlier, later))
        change = change_between(before, after, case.settings.steps_per_revolution)
        if change is not None:
            words = named(later, case.scene, case.settings, change.last_digits)
            yield replace(change, version=later, before=earlier, explained=words)


def change_between(before: Measurement, after: Measurement, steps_per_revolution: int) -> Change | None:
    """Changes from one run to the same in another release, None where nothing did, to the last bit."""
    bits = [(one.payload or {}).get("bits", {}) for one in (before, after)]
    differ = sorted(name for name in bits[0].keys() | bits[1].keys() if bits[0].get(name) != bits[1].get(name))
    ended, errors = (before.outcome, after.outcome), (before.largest("position"), after.largest("position"))
    if not differ and ended[0] == ended[1]:
        return None
    if ended != (Outcome.COMPLETED.slug,) * 2:
        return Change("", "", ended, errors, tuple(differ), {}, ended[0] == ended[1])
    assert after.signed is not None
    size = {
        q: max(float(np.abs(after.signed_errors(p, q) - before.signed_errors(p, q)).max()) for p in after.signed)
        for q in QUANTITIES
    }
    steps_a_radian = steps_per_revolution / (2.0 * math.pi)
    small = all(size[q] <= LAST_DIGITS * steps_a_radian**k for k, q in enumerate(QUANTITIES))
    return Change("", "", ended, errors, tuple(differ), size, small)
