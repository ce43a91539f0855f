"""Runs of a study of releases: each in its release's environment, and only what the ledger does not have."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from functools import partial

from conrod.runs.trajectory import Outcome
from conrod.studies.execution.dispatch import Watcher, run_cases, time_cases
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.timing import Timing, fingerprint
from conrod.studies.versions.case import VersionCase
from conrod.studies.versions.environment import Environments


@dataclass(frozen=True)
class ReleaseRunner:
    """Runs and times cases of one release after the other.

    Attributes:
        jobs: runs at a time.
        timeout, memory: limits of a run [s], [bytes]; None for none.
        fresh, retimed: whether runs, and timings, are made again that the ledger has.
        watching: a watcher, from what it is to say and how cases usually end.
    """

    ledger: Ledger
    jobs: int
    timeout: float | None
    memory: int | None
    fresh: bool
    retimed: bool
    watching: Callable[[str, str], AbstractContextManager[Watcher]]
    environments: Environments = field(default_factory=Environments)

    def perform(
        self, requirement: str, cases: Sequence[VersionCase], timed: Sequence[VersionCase]
    ) -> tuple[Mapping[str, Measurement], Mapping[str, Timing]]:
        """Measurements of cases of one release, and timings of some of them, of those that completed.

        Raises:
            InvalidInput: the release cannot be had.
        """
        keys, made, name = {case.key for case in cases}, self.environments.interpreter, cases[0].settings.engine
        runs: Mapping[str, Measurement] = {} if self.fresh else self.ledger.measurements(keys)
        if runs.keys() < keys:
            with self.watching(f"runs of {requirement}", Outcome.COMPLETED.slug) as bar:
                python = made(name, requirement, cases[0].version)
                processes = partial(LocalProcesses, cell_timeout=self.timeout, cell_memory=self.memory)
                with processes(self.jobs, interpreter=python) as executor:
                    runs = run_cases(cases, self.ledger, executor, fresh=self.fresh, watcher=bar)
        wanted = [case for case in timed if runs[case.key].outcome == Outcome.COMPLETED.slug]
        known = {} if self.retimed else self.ledger.timings([case.key for case in wanted], fingerprint())
        if len(known) == len(wanted):
            return runs, known
        with self.watching(f"costs of {requirement}", "timed") as bar:
            timing = partial(time_cases, cell_timeout=self.timeout, fresh=self.retimed, watcher=bar)
            python = made(name, requirement, cases[0].version)
            return runs, timing(wanted, self.ledger, interpreter=python)
