"""Findings compared with the baseline that an earlier call wrote, see `conrod.studies.frame.baseline`."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput
from conrod.own.models.results import AS_GIVEN, OWN, JudgedRun, ModelStudy
from conrod.own.tables.errors import ERRORS
from conrod.own.tables.study import TableStudy
from conrod.report.writer import environment
from conrod.runs.plain_values import plain_values
from conrod.scenes import Scene
from conrod.scenes.scene import canonical_json
from conrod.studies.frame import baseline
from conrod.studies.frame.baseline import ORDER_PREFIX, BandedNumber, Baseline, BaselineComparison, BaselineLine
from conrod.studies.frame.case import QUANTITIES, identity_digest
from conrod.studies.frame.files import check_writable_folder
from conrod.studies.frame.resolve_arguments import TOLERANCE_NAMES
from conrod.studies.frame.result import Result, SceneResults


@dataclass(frozen=True)
class BaselineCheck:
    """A baseline that was named, looked at before anything is run.

    Attributes:
        scenes: that are studied, by name.
        before: content of the file; None where there is none.
        now: what will be in it, with no results yet.
    """

    file: Path
    accept: bool
    scenes: Mapping[str, Scene]
    before: Baseline | None
    now: Baseline

    @classmethod
    def prepare(
        cls, file: str | Path | None, scenes: Mapping[str, Scene], words: Mapping[str, Any], *, accept: bool
    ) -> BaselineCheck | None:
        """The baseline of a study; None where no file is named.

        Args:
            words: arguments that the motion depends on, by the names of their options; those not given are empty.

        Raises:
            InvalidInput: the file cannot be read or written, or is the baseline of something else.
        """
        if file is None:
            if accept:
                raise InvalidInput("--accept: it is for a baseline, name its file with --baseline")
            return None
        file = Path(file)
        given = {name: value for name, value in words.items() if not (value is None or value in ((), ""))}
        of = {"scene": list(scenes), **given}
        of |= {f"{name}.{one}": value for name, scene in scenes.items() for one, value in scene.parameters.items()}
        digest = identity_digest(
            canonical_json(plain_values([of, [[one.kind, one.identity()] for one in scenes.values()]]))
        )
        now = Baseline(of, digest, {"conrod": version("conrod"), **environment()}, {})
        before = baseline.read_baseline(file) if os.path.lexists(file) else None
        if before is None or accept:
            check_writable_folder(file.parent)
        else:
            baseline.check_same_request(file, before, now)
        return cls(file, accept, scenes, before, now)

    def compare(
        self, found: Sequence[Any], find: Callable[[Sequence[Mapping[str, Scene]]], Sequence[Sequence[Any]]]
    ) -> BaselineComparison:
        """Compare findings with the baseline, which is written where it is to be.

        Args:
            find: finds the same of other scenes: at speeds that differ in the last bits, which shows how far rounding
                carries each number.
        """
        now, drift = replace(self.now, results=_lines_of(found)), None
        if self.before is not None and self.before.hash == now.hash:
            drift = baseline.compare_baselines(self.file, self.before, now)
        if drift is not None and (not self.accept or drift == BaselineComparison(self.file)):
            return replace(drift, accepted=self.accept)
        others = [
            {name: one.with_parameters(speed=one.speed * factor) for name, one in self.scenes.items()}
            for factor in baseline.SPEED_FACTORS
        ]
        like = {AS_GIVEN: OWN} if OWN in now.results else {}
        again = [_lines_of(one) for one in find(others)]
        baseline.write_baseline(self.file, baseline.with_bands(now, again, like))
        return replace(drift or BaselineComparison(self.file), written=True, accepted=self.accept)


def _lines_of(found: Sequence[Any]) -> dict[str, BaselineLine]:
    """The lines of studies of scenes, or of the one of a model or a table."""
    study = found[0]
    if isinstance(study, SceneResults):
        pairs = [(f"{one.name} " if len(found) > 1 else "", result) for one in found for result in one.results]
        return {f"{name}{one.engine} {one.preset or 'kinematic'}": _result(one) for name, one in pairs}
    if isinstance(study, TableStudy):
        sizes = {name: study.largest(name) for name in (*ERRORS, "phase")}
        return {"table": _line("completed", study.passed, sizes)}
    assert isinstance(study, ModelStudy)
    runs = [*study.runs.values(), *([study.own_run] if study.own_run else [])]
    paths = _line("completed", study.is_machine, {"position": study.identity.largest})
    return {"paths": paths} | {run.label: _run(study, run) for run in runs}


def _result(result: Result) -> BaselineLine:
    orders = result.order or {}
    # Whatever may be judged: tolerances may be others the next time.
    names = [*orders, *(TOLERANCE_NAMES if result.preset else QUANTITIES)] if result.completed else []
    sizes = {name: result.judged_error(name) for name in names} | {
        f"{ORDER_PREFIX}{name}": orders[name] for name in orders
    }
    return _line(result.outcome, result.passed, sizes, getattr(result, "settings", None))


def _run(study: ModelStudy, run: JudgedRun) -> BaselineLine:
    passed = not study.exceeded_limits(run) if run in study.judged else None
    sizes = {} if run.errors is None else {q: run.worst(q) for q in QUANTITIES} | {"phase": run.phase}
    return _line(run.outcome.slug, passed, sizes)


def _line(
    outcome: str,
    passed: bool | None,
    sizes: Mapping[str, float | None],
    settings: Mapping[str, Any] | None = None,
) -> BaselineLine:
    numbers = {
        name: BandedNumber(size, 0.0) for name, size in sizes.items() if size is not None and math.isfinite(size)
    }
    return BaselineLine(outcome, passed, numbers, {k: v for k, v in (settings or {}).items() if k != "preset"})
