"""Measured changelog of an engine: the same runs in each of its releases, and where something changed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from conrod.engines import Engine
from conrod.engines.capabilities import Released, required
from conrod.engines.engine import judged_preset, run_of
from conrod.errors import InvalidInput
from conrod.runs.convergence import claimed_order
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.frame.result import refinement_path
from conrod.studies.frame.timing import Timing
from conrod.studies.versions.case import VersionCase
from conrod.studies.versions.findings import LAST_DIGITS, Change, History, VersionRun, VersionStudy

LINKAGE_STEPS, CONTACT_STEPS = 1000, 16000  # per revolution, from which the refinement path follows
Runs = Mapping[str, Measurement]
# Of what is to be installed, cases of one release, and those of them that are timed: measurements and timings by key;
# InvalidInput where the release cannot be had.
Perform = Callable[[str, Sequence[VersionCase], Sequence[VersionCase]], tuple[Runs, Mapping[str, Timing]]]


@dataclass(frozen=True)
class Probe:
    """A scene with some settings, in any release: the run that is reported comes last.

    Attributes:
        path: of a preset a refinement path; of other settings, which only tell releases apart, that run alone.
    """

    name: str
    scene: Scene
    settings: str
    path: tuple[VersionCase, ...]

    def of(self, version: str) -> tuple[VersionCase, ...]:
        """Its cases in a release."""
        return tuple(replace(case, version=version) for case in self.path)


def plan_probes(scenes: Mapping[str, Scene], engine: Engine[Any]) -> list[Probe]:
    """All that is run in each release of an engine.

    Raises:
        InvalidInput: the engine has no list of its releases.
    """
    made, found = required(engine, Released), []
    for name, scene in scenes.items():
        steps = refinement_path(scene, CONTACT_STEPS if scene.kinematics.mechanism.cam_contacts else LINKAGE_STEPS)
        by_steps = [made.probes(scene, n) for n in steps]
        # One stretch for all steps of an input that makes one pass: that of the longest.
        start, turns = run_of(scene, min(steps), 2.0)
        for label in by_steps[-1]:
            path = by_steps if label in engine.presets else by_steps[-1:]
            cases = (VersionCase(name, scene, probes[label], turns, start, version="") for probes in path)
            found.append(Probe(name, scene, label, tuple(cases)))
    return found


def versions_study(
    engine: Engine[Any], versions: Sequence[str], probes: Sequence[Probe], perform: Perform
) -> VersionStudy:
    """Findings on releases of an engine, the oldest first; a release that cannot be had is unsupported, others go on.

    Raises:
        InvalidInput: none of them can be had; says why of the last.
    """
    releases, runs = required(engine, Released).releases, dict[str, Runs]()
    times, unsupported = dict[str, Mapping[str, Timing]](), dict[str, str]()
    for version in versions:
        cases = [case for probe in probes for case in probe.of(version)]
        timed = [probe.of(version)[-1] for probe in probes if probe.settings == judged_preset(engine)]
        try:
            runs[version], times[version] = perform(releases.requirement(version), cases, timed)
        except InvalidInput as error:
            unsupported[version] = str(error)
            if len(unsupported) == len(versions):
                raise InvalidInput(f"{engine.name} {version}: {error}") from None
    histories = tuple(
        History(
            scene=probe.name,
            settings=probe.settings,
            steps_per_revolution=probe.path[-1].settings.steps_per_revolution,
            runs=tuple(_run(probe.of(version), runs[version], times[version]) for version in runs),
            changes=tuple(_changes(probe, runs, releases.named)),
        )
        for probe in probes
    )
    return VersionStudy(engine.name, releases.source, tuple(runs), unsupported, histories)


def _run(path: Sequence[VersionCase], runs: Runs, times: Mapping[str, Timing]) -> VersionRun:
    finest, timing = runs[path[-1].key], times.get(path[-1].key)
    errors = {q: finest.largest(q) for q in QUANTITIES}
    steps = [(case.settings.steps_per_revolution, runs[case.key]) for case in path]
    return VersionRun(
        version=path[-1].version,
        outcome=finest.outcome,
        reason=finest.reason,
        errors=errors,
        order={q: claimed_order((n, one.largest(q)) for n, one in steps) for q in QUANTITIES},
        seconds=None if timing is None else timing.seconds_per_revolution,
        ratio=None if timing is None else timing.ratio,
    )


def _changes(probe: Probe, runs: Mapping[str, Runs], named: Callable[..., tuple[str, ...]]) -> Iterable[Change]:
    for earlier, later in pairwise(runs):
        case, before = probe.of(later)[-1], runs[earlier][probe.of(earlier)[-1].key]
        change = change_between(before, runs[later][case.key], case.settings.steps_per_revolution)
        if change is not None:
            words = named(later, probe.scene, case.settings, change.last_digits)
            yield replace(change, version=later, before=earlier, explained=words)


def change_between(before: Measurement, after: Measurement, steps_per_revolution: int) -> Change | None:
    """What changed from one run to the same in another release, None where nothing did, to the last bit."""
    bits = [(one.beside or {}).get("bits", {}) for one in (before, after)]
    differ = sorted(name for name in bits[0].keys() | bits[1].keys() if bits[0].get(name) != bits[1].get(name))
    ended = (before.outcome, after.outcome)
    if not differ and ended[0] == ended[1]:
        return None
    if ended != (Outcome.COMPLETED.slug,) * 2:
        return Change("", "", ended, tuple(differ), {}, ended[0] == ended[1])
    assert after.signed is not None
    size = {
        q: max(float(np.abs(after.signed_of(p, q) - before.signed_of(p, q)).max()) for p in after.signed)
        for q in QUANTITIES
    }
    steps_a_radian = steps_per_revolution / (2.0 * math.pi)
    small = all(size[q] <= LAST_DIGITS * steps_a_radian**k for k, q in enumerate(QUANTITIES))
    return Change("", "", ended, tuple(differ), size, small)
