"""Findings of `conrod validate` as the lines of a baseline, and held against the one that --baseline names."""

from __future__ import annotations

import hashlib
import math
import os
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import msgspec

from conrod.cli.options import RunOptions, as_given
from conrod.cli.validate_request import BaselineOptions, Request
from conrod.errors import InvalidInput
from conrod.own.models.runs import JudgedRun
from conrod.own.models.study import AS_GIVEN, OWN, ModelStudy
from conrod.own.tables.samples import ERRORS
from conrod.own.tables.study import TableStudy
from conrod.report.terminal import console, print_lines
from conrod.report.writer import environment
from conrod.runs.plain import plain
from conrod.scenes import Scene
from conrod.scenes.canonical import canonical
from conrod.studies.frame.baseline import Baseline, Line, Number, read, renew
from conrod.studies.frame.case import key_of
from conrod.studies.frame.drift import ORDER, Held, OtherBaseline, check_same, compared
from conrod.studies.frame.files import check_writable_folder
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.frame.resolve_arguments import TOLERANCES
from conrod.studies.frame.result import Result, SceneResults

Again = Callable[[Sequence[float]], Sequence[Sequence[Any]]]
# What does not change the motion that is compared.
NO_PART = (RunOptions, BaselineOptions, "tolerance", "scene", "assignments", "out", "document", "figures", "qualify")
# Of a result, what was asked for and not found.
ASKED_FOR = ("scene", "engine_version", "parameters", "settings", "tolerance", "passed", "reason", "qualified")


def lines_of(study: Any) -> dict[str, Line]:
    """The lines of a study of a scene, of a model or of a table."""
    if isinstance(study, SceneResults):
        return {" ".join(filter(None, (r.engine, r.preset or "kinematic"))): _result(r) for r in study.results}
    if isinstance(study, TableStudy):
        found = {name: study.largest(name) for name in (*ERRORS, "phase")}
        return {"table": _line("completed", study.passed, found, {}, study.errors)}
    assert isinstance(study, ModelStudy)
    runs = dict(study.runs) | ({study.own_run.run.label: study.own_run.run} if study.own_run else {})
    identity = study.identity
    paths = _line("completed", study.is_machine, {"position": identity.largest}, {}, identity.off)
    return {"paths": paths} | {label: _run(study, run) for label, run in runs.items()}


def _result(result: Result) -> Line:
    # Whatever is judged: tolerances may be others the next time.
    names = [*(result.order or {}), *(TOLERANCES if result.preset else QUANTITIES)]
    sizes = {name: result.judged_error(name) for name in names} if result.completed else {}
    shown = {k: v for k, v in vars(result).items() if k not in ASKED_FOR}
    return _line(result.outcome, result.passed, sizes, result.order or {}, shown, getattr(result, "settings", None))


def _run(study: ModelStudy, run: JudgedRun) -> Line:
    passed = not study.exceeded(run) if run in study.judged else None
    sizes = {q: run.worst(q) for q in QUANTITIES} | {"phase": run.phase}
    completed = run.errors is not None
    return _line(run.outcome.slug, passed, sizes if completed else {}, {}, (run.errors, run.phase, run.ripple, run.gap))


def _line(
    outcome: str,
    passed: bool | None,
    sizes: Mapping[str, float | None],
    orders: Mapping[str, float | None],
    shown: Any,
    settings: Mapping[str, Any] | None = None,
) -> Line:
    values = {**sizes, **{f"{ORDER}{name}": order for name, order in orders.items()}}
    numbers = {name: Number(value, 0.0) for name, value in values.items() if value is not None and math.isfinite(value)}
    bits = hashlib.sha256(msgspec.json.encode(plain(shown))).hexdigest()[:16]
    return Line(outcome, passed, numbers, bits, {k: v for k, v in (settings or {}).items() if k != "preset"})


def line_name(found: Sequence[Any], study: Any, label: str) -> str:
    """Name of a line of one of some studies: with that of its scene where there are several."""
    return f"{study.name} {label}" if len(found) > 1 else label


def _all_lines(found: Sequence[Any]) -> dict[str, Line]:
    return {line_name(found, study, label): line for study in found for label, line in lines_of(study).items()}


@dataclass(frozen=True)
class Holding:
    """The baseline that --baseline names, looked at before anything is run.

    Attributes:
        before: what the file has; None where there is none.
        now: what will be in it, with no results yet.
    """

    file: Path
    accept: bool
    before: Baseline | None
    now: Baseline

    @classmethod
    def of(cls, asked: Request, scenes: Mapping[str, Scene]) -> Holding | None:
        """The one for a study of scenes, by name; None where none was asked for.

        Raises:
            InvalidInput: the file cannot be read or written, or is the baseline of something else.
        """
        if asked.baseline is None:
            if asked.accept:
                raise InvalidInput("--accept: it is for a baseline, name its file with --baseline")
            return None
        of = {"scene": list(scenes)} | {name.lstrip("-"): value for name, value in as_given(asked, *NO_PART).items()}
        of |= {f"{name}.{one}": value for name, scene in scenes.items() for one, value in scene.parameters.items()}
        digest = key_of(canonical(plain([of, [[one.kind, one.identity()] for one in scenes.values()]])))
        now = Baseline(of, digest, {"conrod": version("conrod"), **environment()}, {})
        file = Path(asked.baseline)
        before = read(file) if os.path.lexists(file) else None
        if before is None or asked.accept:
            check_writable_folder(file.parent)
        else:
            check_same(file, before, now)
        return cls(file, asked.accept, before, now)

    def held(self, found: Sequence[Any], again: Again, costs: Callable[[], Mapping[str, float]] = dict) -> Held:
        """Studies held against the baseline, which is written where it is to be.

        Args:
            again: the same studies at speeds times each of some factors.
            costs: by the name of a line.
        """
        now, drift = replace(self.now, results=_all_lines(found)), Held(self.file)
        if self.before is not None:
            try:
                drift = compared(self.file, self.before, now)
            except OtherBaseline:
                if not self.accept:
                    raise
            else:
                if not self.accept or drift == Held(self.file):
                    return replace(drift, accepted=self.accept)
        like = {AS_GIVEN: OWN} if OWN in now.results else {}
        renew(self.file, now, lambda factors: [_all_lines(one) for one in again(factors)], costs(), like)
        return replace(drift, written=True, accepted=self.accept)


def at_speeds(scenes: Mapping[str, Scene], factor: float) -> dict[str, Scene]:
    """Scenes at their speeds times a factor."""
    return {name: scene.with_parameters(speed=scene.speed * factor) for name, scene in scenes.items()}


def print_held(held: Held) -> None:
    """What was found, and the command that accepts it."""
    print_lines(console(), held.text.splitlines())
    if not held.passed and not held.written:
        print_lines(console(), [f"accept it: {shlex.join(['conrod', *sys.argv[1:], '--accept'])}"])
