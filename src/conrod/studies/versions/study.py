"""Measured changelog of an engine: the same runs in each release, and their changes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from conrod.comparison.trajectory import Outcome
from conrod.engines import Engine
from conrod.engines.capabilities import KnownReleases, require_capability
from conrod.engines.engine import run_extent
from conrod.errors import InvalidInput
from conrod.exact.motion import QUANTITIES
from conrod.execution.case import Results
from conrod.execution.paired_timing import PairedTiming
from conrod.execution.reference_guard import ReferenceGuard
from conrod.execution.releases import ReleaseResult, VersionCase
from conrod.scenes import Scene

# Largest change of a normalised position that counts as last digits. For velocities and accelerations it is multiplied
# by the steps per radian and their square, because a derivative over a step enlarges rounding as much.
MAX_LAST_DIGITS_CHANGE = 1e-12


@dataclass(frozen=True)
class ReleaseChange:
    """Change of a run from one release to the next.

    Attributes:
        version, before: the release with the change, and the release before.
        outcomes: outcomes before and after.
        errors: largest position errors before and after, normalised; None unless the run completed.
        differ: names of the states and outputs that differ in any bit.
        size: largest difference of the two motions by quantity, at twenty crank angles of the last turn, normalised as
            errors are; empty unless both completed.
        last_digits: True if only last digits changed, also if bits differ and the size is unknown.
        explained: entries of the engine's changelog that can be the cause; empty if there are none.
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
class RunHistory:
    """History of one run, a scene with some settings, through all releases.

    Attributes:
        settings: name of the settings.
        changes: changes in any bit from one release to the next.
    """

    scene: str
    settings: str
    steps_per_revolution: int
    changes: tuple[ReleaseChange, ...]

    def change_at(self, version: str) -> ReleaseChange | None:
        """Return the change that a release brought; None if the run is the same to the last bit."""
        return next((change for change in self.changes if change.version == version), None)


@dataclass(frozen=True)
class ReleaseCost:
    """CPU time of a run in a release, relative to that in the reference release.

    Attributes:
        timing: the release against the reference; None if it cannot be timed.
        noise: the reference against itself, in two processes; None as above.
        reason: why it cannot be timed.
    """

    version: str
    scene: str
    settings: str
    timing: PairedTiming | None
    noise: PairedTiming | None
    reason: str = ""

    @property
    def word(self) -> str:
        """`slower` or `faster` where the interval is beyond 1 and beyond the scatter of the reference."""
        return "" if self.timing is None or self.noise is None else self.timing.against_noise(self.noise)


@dataclass(frozen=True)
class VersionStudy:
    """Findings on the releases of an engine.

    Attributes:
        source: address of the engine's changelog.
        measured: versions that were run, the oldest first.
        unsupported: reasons why versions could not be installed, by version.
        histories: history of each scene with each settings.
        distrust: scenes and engines whose figures cannot be trusted, and why, in words; empty if all can.
        reference: release that costs are relative to; empty if none were asked for.
        costs: costs of the runs that complete in both releases.
    """

    engine: str
    source: str
    measured: tuple[str, ...]
    unsupported: Mapping[str, str]
    histories: tuple[RunHistory, ...]
    distrust: str = ""
    reference: str = ""
    costs: tuple[ReleaseCost, ...] = ()

    def changes_at(self, version: str) -> tuple[tuple[RunHistory, ReleaseChange], ...]:
        """Return the changes that a release brought, each with its history."""
        return tuple((one, change) for one in self.histories if (change := one.change_at(version)) is not None)


LINKAGE_STEPS, CONTACT_STEPS, REVOLUTIONS = 1000, 8000, 2.0  # steps per revolution; revolutions


def release_cases(scenes: Mapping[str, Scene], engine: Engine[Any]) -> dict[tuple[str, str], VersionCase]:
    """Return the cases that each release runs, by scene and settings name.

    Their version is empty, to be replaced by that of a release.

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
    perform: Callable[[str, Sequence[VersionCase]], Results],
    time: Callable[[VersionCase, VersionCase], PairedTiming] | None = None,
) -> VersionStudy:
    """Run all cases in each release of an engine, and return the changes between releases.

    A release that cannot be installed is reported as unsupported, and the others are run.

    Args:
        engine: the engine.
        versions: releases to run, the oldest first.
        cases: cases as `release_cases` returns them.
        perform: runs cases in a release, given its requirement for pip, and returns results by key; raises
            InvalidInput if the release cannot be installed.
        time: times a case of one release against that of another; raises InvalidInput if it cannot. None for no costs.

    Raises:
        InvalidInput: no release can be installed; says why the last one cannot.
    """
    releases = require_capability(engine, KnownReleases).releases
    runs, unsupported = dict[str, Results](), dict[str, str]()
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
        RunHistory(
            scene=scene,
            settings=settings,
            steps_per_revolution=case.settings.steps_per_revolution,
            changes=tuple(_release_changes(case, runs, releases.matching_entries)),
        )
        for (scene, settings), case in cases.items()
    )
    found = VersionStudy(engine.name, releases.source, tuple(runs), unsupported, histories, guard.distrust)
    if time is None:
        return found
    reference = engine.version if engine.version in runs else next(iter(runs))
    return replace(found, reference=reference, costs=tuple(_release_costs(cases, runs, reference, time)))


def _release_costs(
    cases: Mapping[tuple[str, str], VersionCase],
    runs: Mapping[str, Results],
    reference: str,
    time: Callable[[VersionCase, VersionCase], PairedTiming],
) -> Iterator[ReleaseCost]:
    """Yield the cost of each run in each other release, where it completes there and in the reference."""
    for (scene, settings), case in cases.items():
        here, noise = replace(case, version=reference), None
        for version in runs:
            there = replace(case, version=version)
            if version == reference or not (runs[reference][here.key].completed and runs[version][there.key].completed):
                continue
            try:
                noise = noise or time(here, here)
                yield ReleaseCost(version, scene, settings, time(there, here), noise)
            except InvalidInput as error:
                yield ReleaseCost(version, scene, settings, None, None, str(error))


def _release_changes(
    case: VersionCase, runs: Mapping[str, Results], matching_entries: Callable[..., tuple[str, ...]]
) -> Iterable[ReleaseChange]:
    """Yield the changes of a case between releases, with entries that may explain them."""
    for earlier, later in pairwise(runs):
        before, after = (runs[version][replace(case, version=version).key] for version in (earlier, later))
        change = change_between(before, after, case.settings.steps_per_revolution)
        if change is not None:
            words = matching_entries(later, case.scene, case.settings, change.last_digits)
            yield replace(change, version=later, before=earlier, explained=words)


def change_between(before: ReleaseResult, after: ReleaseResult, steps_per_revolution: int) -> ReleaseChange | None:
    """Return the change of a run between two releases; None if equal to the last bit."""
    names = before.bits.keys() | after.bits.keys()
    differ = sorted(name for name in names if before.bits.get(name) != after.bits.get(name))
    ended, errors = (before.outcome, after.outcome), (before.largest("position"), after.largest("position"))
    if not differ and ended[0] == ended[1]:
        return None
    if ended != (Outcome.COMPLETED.slug,) * 2:
        return ReleaseChange("", "", ended, errors, tuple(differ), {}, ended[0] == ended[1])
    assert after.signed is not None
    size = {
        q: max(float(np.abs(after.signed_errors(p, q) - before.signed_errors(p, q)).max()) for p in after.signed)
        for q in QUANTITIES
    }
    steps_a_radian = steps_per_revolution / (2.0 * math.pi)
    small = all(size[q] <= MAX_LAST_DIGITS_CHANGE * steps_a_radian**k for k, q in enumerate(QUANTITIES))
    return ReleaseChange("", "", ended, errors, tuple(differ), size, small)
