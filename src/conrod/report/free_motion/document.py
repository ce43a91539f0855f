"""Free motion as JSON; no CPU time, which is another one every time."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from conrod.report import numbers
from conrod.report.free_motion.words import verdict_words
from conrod.studies.free_motion.results import MotionResult, MotionStudy
from conrod.studies.validation.serialise import environment

SCHEMA = 1


def motions_text(studies: Sequence[MotionStudy]) -> str:
    """The document that `conrod validate --motion --json` writes; what is not available is None."""
    document = {
        "schema": SCHEMA,
        "conrod": version("conrod"),
        "environment": environment(),
        "motions": [motion_entry(study) for study in studies],
    }
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def page_document(study: MotionStudy, command: str) -> str:
    """The numbers of a page, rounded as in its tables."""
    entry = motion_entry(study)
    results = [
        _rounded(one) | {"verdict": verdict_words(r)} for one, r in zip(entry["results"], study.results, strict=True)
    ]
    exact = entry["exact"] | {"drift": _rounded(entry["exact"]["drift"])}
    document = {"schema": SCHEMA, "conrod": version("conrod"), "command": command} | entry
    document |= {"exact": exact, "results": results}
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def motion_entry(study: MotionStudy) -> dict[str, Any]:
    """One scene as plain values, in SI units and normalised errors."""
    return {
        "scene": study.name,
        "title": study.scene.title,
        "parameters": dict(study.scene.parameters),
        "motion": study.motion,
        "left_out": list(study.left_out),
        "exact": {"drift": study.exact.drift, "continuation": study.exact.continuation or None},
        "passed": study.passed,
        "results": [_result(result) for result in study.results],
    }


def _result(result: MotionResult) -> dict[str, Any]:
    return {
        "engine": result.engine,
        "engine_version": result.engine_version,
        "preset": result.preset,
        "step": result.step,
        "seconds": result.seconds,
        "outcome": result.outcome,
        "reason": result.reason or None,
        "errors": None if result.errors is None else {name: dict(sizes) for name, sizes in result.errors.items()},
        "angle": None if result.angle is None else dict(result.angle),
        "energy": None if result.energy is None else dict(result.energy),
        "leaving": result.leaving,
        "leaves": result.leaves,
        "order": None if result.order is None else dict(result.order),
        "refinement": [asdict(point) for point in result.refinement] or None,
        "tolerance": dict(result.tolerance) or None,
        "passed": result.passed,
    }


# Written as they were given; everything else that is a fraction was measured.
GIVEN = {"step", "seconds", "leaving", "tolerance", "leaves"}


def _rounded(value: Any, given: bool = False) -> Any:
    match value:
        case float() if given:
            return numbers.rounded(value, 12)
        case float() if abs(value) < numbers.ROUNDING:
            return numbers.BELOW_ROUNDING
        case float():
            return numbers.rounded(value, 2)
        case Mapping():
            return {key: _rounded(part, given or key in GIVEN) for key, part in value.items()}
        case list() | tuple():
            return [_rounded(part, given) for part in value]
        case _:
            return value
