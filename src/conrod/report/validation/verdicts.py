"""What a result amounts to, in words."""

from __future__ import annotations

from conrod.report import numbers
from conrod.runs.trajectory import Outcome
from conrod.studies.validation.results import Result

PLAIN_NAMES = {"velocity_rms": "velocity (rms)", "total": "position at time t"}


def verdict(result: Result) -> str:
    """Within tolerance or not, and if not why; what ended the run, where it did not complete."""
    if result.outcome == Outcome.UNSUPPORTED.slug:
        return f"unsupported: {result.reason or Outcome.UNSUPPORTED.meaning}"
    if result.outcome != Outcome.COMPLETED.slug:
        failed = f"**failed**, {result.outcome}: {result.reason or Outcome.of(result.outcome).meaning}"
        return failed if result.passed is False else failed.replace("**failed**", "did not complete")
    if result.passed is None:
        return "measured, not judged"
    if result.passed:
        return "within tolerance"
    return "**out of tolerance**: " + "; ".join(exceeded(result) or ["see the tables"])


def short_verdict(result: Result) -> str:
    """The verdict without its reasons."""
    return verdict(result) if result.passed is None else verdict(result).split(":")[0]


def exceeded(result: Result) -> list[str]:
    """The judged quantities that are out of tolerance, with what was found and allowed."""
    reasons = []
    for name, (found, allowed) in result.exceeded().items():
        plain = PLAIN_NAMES.get(name, name)
        if found is None:
            reasons.append(f"{plain} has no error to judge")
        else:
            reasons.append(f"{plain} {numbers.measured(found)} > {numbers.measured(allowed)}")
    printed = result.printed
    if printed is not None and printed.engine_agrees != printed.exact_agrees:
        reasons.append(f"the printed table, {printed.engine_agrees} of {printed.exact_agrees} cells met")
    return reasons
