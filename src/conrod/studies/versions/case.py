"""Runs in named releases of an engine, each in its environment; states and outputs are kept to the last bit."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from conrod.engines import engine_named
from conrod.engines.running import followed
from conrod.errors import InvalidInput
from conrod.runs.run_errors import RunErrors
from conrod.runs.trajectory import Outcome
from conrod.studies.execution.dispatch import Watcher, run_cases
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import RunCase, SignedErrors, as_run, not_run
from conrod.studies.limits.recorders import Fingerprint
from conrod.studies.versions.environment import Environments

BITS_VERSION = 1  # raised when what is kept of a run comes out otherwise, or means something else, than before


@dataclass(frozen=True, kw_only=True)
class VersionCase(RunCase):
    """A run in a release of its engine, to be performed where that is installed.

    Attributes:
        version: of the engine.
    """

    version: str

    @property
    def engine_version(self) -> str:
        return self.version

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        return super()._identity(parameters) | {"bits": BITS_VERSION}

    def perform(self) -> Measurement:
        engine, case = engine_named(self.settings.engine), as_run(self)
        if engine.version != self.version:
            raise InvalidInput(f"{engine.name} {engine.version} was to run what is for {self.version}")
        try:
            if (unsupported := not_run(case, case.scene)) is not None:
                return unsupported
            errors, signed, bits = RunErrors(), SignedErrors(case), Fingerprint()
            span = case.revolutions, case.start_angle
            ended = followed(engine, case.scene, case.settings, *span, errors, signed, every=bits.add)
        except InvalidInput:
            raise
        except (AttributeError, TypeError) as error:
            # Of a release that has not what conrod asks of it, which no table of ours foresaw.
            return Measurement(Outcome.UNSUPPORTED.slug, f"conrod cannot drive it: {type(error).__name__}: {error}")
        except Exception as error:  # the engine's own, of whatever kind: an old release fails in its own ways
            return Measurement(Outcome.CRASHED.slug, f"{type(error).__name__}: {' '.join(str(error).split())}")
        found: dict[str, Any] = {}
        if ended.outcome is Outcome.COMPLETED:
            found = {**errors.found(), "signed": signed.errors()}
        return Measurement(ended.outcome.slug, ended.reason, **found, beside={"bits": bits.texts()})


@dataclass(frozen=True)
class ReleaseRunner:
    """Runs cases of one release after the other.

    Attributes:
        jobs: runs at a time.
        timeout, memory: limits of a run [s], [bytes]; None for none.
        fresh: whether runs are made again that the ledger has.
        watching: a watcher, from what it is to say and how cases usually end.
    """

    ledger: Ledger
    jobs: int
    timeout: float | None
    memory: int | None
    fresh: bool
    watching: Callable[[str, str], AbstractContextManager[Watcher]]
    environments: Environments = field(default_factory=Environments)

    def perform(self, requirement: str, cases: Sequence[VersionCase]) -> Mapping[str, Measurement]:
        """Measurements of cases of one release.

        Raises:
            InvalidInput: the release cannot be had.
        """
        keys = {case.key for case in cases}
        runs: Mapping[str, Measurement] = {} if self.fresh else self.ledger.measurements(keys)
        if runs.keys() >= keys:
            return runs
        with self.watching(f"runs of {requirement}", Outcome.COMPLETED.slug) as bar:
            python = self.environments.interpreter(cases[0].settings.engine, requirement, cases[0].version)
            processes = partial(LocalProcesses, cell_timeout=self.timeout, cell_memory=self.memory)
            with processes(self.jobs, interpreter=python) as executor:
                return run_cases(cases, self.ledger, executor, fresh=self.fresh, watcher=bar)
