"""Validation results as JSON."""

from __future__ import annotations

import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from conrod.engines.registry import engine_packages
from conrod.studies.validation.results import Result, SceneStudy

SCHEMA = 1


def results_document(studies: Sequence[SceneStudy]) -> dict[str, Any]:
    """The document that `conrod validate --json` writes; what is not available is None."""
    return {
        "schema": SCHEMA,
        "conrod": version("conrod"),
        "environment": environment(),
        "results": [result_entry(result) for study in studies for result in study.results],
    }


def environment() -> dict[str, str]:
    """What the results were made with."""
    return {
        "python": platform.python_version(),
        "machine": platform.machine(),
        "system": platform.system(),
        **{name: version(name) for name in (*engine_packages(), "numpy")},
    }


def result_entry(result: Result) -> dict[str, Any]:
    """One result as plain values, in SI units and normalised errors."""
    return {
        "scene": result.scene,
        "parameters": dict(result.parameters),
        "engine": result.engine,
        "engine_version": result.engine_version,
        "preset": result.preset,
        "settings": None if result.settings is None else dict(result.settings),
        "mode": result.mode,
        "steps_per_revolution": result.steps_per_revolution,
        "revolutions": result.revolutions,
        "outcome": result.outcome,
        "reason": result.reason or None,
        "errors": _nested(result.errors),
        "peak": _nested(result.peak),
        "closure": _plain(result.closure),
        "phase": _plain(result.phase),
        "drive": _plain(result.drive),
        "order": _plain(result.order),
        "refinement": [asdict(point) for point in result.refinement] or None,
        "tolerance": asdict(result.tolerance) if result.tolerance.judged() else None,
        "prediction": _nested(result.prediction),
        "printed_table": None if result.printed is None else asdict(result.printed),
        "lift_error": result.lift_error,
        "passed": result.passed,
    }


def _plain(values: Mapping[str, Any] | None) -> dict[str, Any] | None:
    return None if values is None else dict(values)


def _nested(values: Mapping[str, Mapping[str, Any]] | None) -> dict[str, Any] | None:
    return None if values is None else {name: dict(inner) for name, inner in values.items()}
