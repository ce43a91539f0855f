"""Runs that did not complete, a row for each rule."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.report.charts.styles import engine_title
from conrod.report.tables import table
from conrod.studies.sweep.results import COMPLETED, SweepStudy, SweptPoint


def failures_table(study: SweepStudy) -> str:
    """Rule, and how it ends at which numbers of steps."""
    rows = []
    for (engine, rule), points in _by_rule(study).items():
        if not all(point.completed for point in points):
            counted = f"{sum(not p.completed for p in points)} of {len(points)}"
            rows.append([engine_title(engine), rule, counted, "; ".join(spans(points))])
    return table(["engine", "settings", "runs that did not complete", "steps per revolution: how they ended"], rows)


def spans(points: Sequence[SweptPoint]) -> list[str]:
    """Neighbouring numbers of steps with one outcome, together: `20 to 100: diverged`."""
    ordered = sorted(points, key=lambda p: p.steps_per_revolution)
    groups: list[tuple[str, list[SweptPoint]]] = []
    for point in ordered:
        outcome = point.measurement.outcome
        if groups and groups[-1][0] == outcome:
            groups[-1][1].append(point)
        else:
            groups.append((outcome, [point]))
    said = []
    for outcome, together in groups:
        if outcome != COMPLETED:
            first, last = together[0].steps_per_revolution, together[-1].steps_per_revolution
            reasons = {p.measurement.reason for p in together}
            reason = next(iter(reasons)) if outcome == "unsupported" and len(reasons) == 1 else ""
            said.append(
                f"{first if first == last else f'{first} to {last}'}: {outcome}" + (f" ({reason})" * bool(reason))
            )
    return said


def _by_rule(study: SweepStudy) -> dict[tuple[str, str], list[SweptPoint]]:
    rules: dict[tuple[str, str], list[SweptPoint]] = {}
    for point in study.points:
        rules.setdefault((point.engine, point.rule), []).append(point)
    return rules
