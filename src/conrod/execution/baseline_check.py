"""Compare findings with the baseline that an earlier call wrote, see `conrod.execution.baseline`."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, TypeVar

from conrod.comparison.plain_values import plain_values
from conrod.engines import environment
from conrod.errors import InvalidInput
from conrod.exact.motion import QUANTITIES
from conrod.execution import baseline
from conrod.execution.baseline import ORDER_PREFIX, BandedNumber, Baseline, BaselineComparison, BaselineLine, KeptCost
from conrod.execution.case import identity_digest
from conrod.execution.files import check_writable_folder
from conrod.execution.result import JudgedResult, SceneResults
from conrod.execution.tolerances import ALL_TOLERANCE_NAMES
from conrod.scenes import Scene
from conrod.scenes.scene import canonical_json

Study = TypeVar("Study")


@dataclass(frozen=True)
class BaselineCheck:
    """A baseline file that the user named, read before anything is run.

    Attributes:
        scenes: scenes that are studied, by name.
        before: content of the file; None where there is none.
        now: the baseline that will be written, with no results yet.
    """

    file: Path
    accept: bool
    scenes: Mapping[str, Scene]
    before: Baseline | None
    now: Baseline

    @classmethod
    def prepare(
        cls, file: str | Path | None, scenes: Mapping[str, Scene], options: Mapping[str, Any], *, accept: bool
    ) -> BaselineCheck | None:
        """The baseline of a study; None where no file is named.

        Args:
            options: arguments that the motion depends on, by the names of their options; those not given are empty.

        Raises:
            InvalidInput: the file cannot be read or written, or is the baseline of another request.
        """
        if file is None:
            if accept:
                raise InvalidInput("--accept: it is for a baseline, name its file with --baseline")
            return None
        file = Path(file)
        given = {name: value for name, value in options.items() if not (value is None or value in ((), ""))}
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
        self,
        found: Sequence[Study],
        find: Callable[[Sequence[Mapping[str, Scene]]], Sequence[Sequence[Study]]],
        lines_of: Callable[[Sequence[Study]], dict[str, BaselineLine]],
        bands_like: Mapping[str, str] | None = None,
        costs: Mapping[str, KeptCost] | None = None,
        cost_ratio: float | None = None,
    ) -> BaselineComparison:
        """Compare findings with the baseline; write it if it is missing, or if the user accepts the findings.

        Args:
            find: repeats the study with scenes whose speeds differ in the last bits, which shows how far rounding
                carries each number.
            lines_of: returns the findings as the lines of a baseline, by their names.
            bands_like: lines that no change of speed reaches, each with another line whose bands it takes over.
            costs: costs of the runs; empty if they are not asked for.
            cost_ratio: cost over that of the baseline above which it fails; None to judge no cost.
        """
        now, drift = replace(self.now, results=lines_of(found), costs=costs or {}), None
        if self.before is not None and self.before.hash == now.hash:
            drift = baseline.compare_baselines(self.file, self.before, now)
            if not self.accept:
                _check_costs_kept(self.file, self.before, now)
                drift = replace(drift, costs=baseline.compare_costs(self.before, now, cost_ratio))
        unchanged = drift == BaselineComparison(self.file) and not now.costs  # costs that were asked for are kept anew
        if drift is not None and (not self.accept or unchanged):
            return replace(drift, accepted=self.accept)
        others = [
            {name: one.with_parameters(speed=one.speed * factor) for name, one in self.scenes.items()}
            for factor in baseline.SPEED_FACTORS
        ]
        like = {line: other for line, other in (bands_like or {}).items() if other in now.results}
        again = [lines_of(one) for one in find(others)]
        baseline.write_baseline(self.file, baseline.with_bands(now, again, like))
        return replace(drift or BaselineComparison(self.file), written=True, accepted=self.accept)


def _check_costs_kept(file: Path, before: Baseline, now: Baseline) -> None:
    if now.costs and not before.costs:
        raise baseline.OtherBaseline(f"the baseline {file} has no costs: accept it with --cost-ratio to have them kept")


def scene_lines(found: Sequence[SceneResults[Any]]) -> dict[str, BaselineLine]:
    """Return the results on scenes as lines of a baseline: one for each engine and preset."""
    pairs = [(one.name, result) for one in found for result in one.results]
    return {line_name(name, result, several=len(found) > 1): _result_line(result) for name, result in pairs}


def line_name(scene: str, result: JudgedResult, *, several: bool) -> str:
    """Name of a result's line: engine and preset, after the scene if several scenes are compared."""
    return f"{scene} " * several + f"{result.engine} {result.preset or 'kinematic'}"


def _result_line(result: JudgedResult) -> BaselineLine:
    orders = result.order or {}
    # Whatever may be judged: tolerances may be others the next time.
    names = [*orders, *(ALL_TOLERANCE_NAMES if result.preset else QUANTITIES)] if result.completed else []
    sizes = {name: result.judged_error(name) for name in names} | {
        f"{ORDER_PREFIX}{name}": orders[name] for name in orders
    }
    return baseline_line(result.outcome, result.passed, sizes, getattr(result, "settings", None))


def baseline_line(
    outcome: str,
    passed: bool | None,
    sizes: Mapping[str, float | None],
    settings: Mapping[str, Any] | None = None,
) -> BaselineLine:
    """Return a line of a baseline from an outcome, a verdict, and sizes; sizes without a number are left out."""
    numbers = {
        name: BandedNumber(size, 0.0) for name, size in sizes.items() if size is not None and math.isfinite(size)
    }
    return BaselineLine(outcome, passed, numbers, {k: v for k, v in (settings or {}).items() if k != "preset"})
