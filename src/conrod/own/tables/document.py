"""A judged table as JSON: SI units and normalised errors, full precision."""

from __future__ import annotations

import json
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from conrod.own.tables.estimation import Estimation
from conrod.own.tables.study import TableStudy
from conrod.studies.validation.serialise import environment

SCHEMA = 1


def table_document(study: TableStudy) -> dict[str, Any]:
    """What `conrod validate TABLE --json` writes; what is not available is None."""
    return {
        "schema": SCHEMA,
        "conrod": version("conrod"),
        "environment": environment(),
        "table": {
            "file": study.file,
            "form": study.form,
            "rows": study.rows,
            "span": list(study.span),
            "step": study.step,
            "columns": [
                {
                    "quantity": c.target.name,
                    "heading": c.heading,
                    "unit": c.unit,
                    "factor": c.factor,
                    "unit_from": c.told_by,
                }
                for c in study.columns
            ],
            "unused_columns": list(study.unused),
        },
        "scene": study.scene_name,
        "parameters": dict(study.scene.parameters),
        "revolutions": study.revolutions,
        "lengths": dict(study.scene.lengths),
        "figure": study.largest("total"),
        "errors": {
            point: {name: asdict(curve.size) for name, curve in errors.items()}
            for point, errors in study.errors.items()
        },
        "components": dict(study.components),
        "crank": _crank(study),
        "estimation": None if study.estimation is None else _estimation(study.estimation),
        "tolerance": dict(study.tolerance) or None,
        "exceeded": {name: {"found": found, "allowed": limit} for name, (found, limit) in study.exceeded.items()},
        "causes": [
            {"kind": cause.kind, "text": cause.text, "explains": {k: list(v) for k, v in cause.explains.items()}}
            for cause in study.causes
        ],
        "notes": list(study.notes),
        "passed": study.passed,
    }


def table_text(document: dict[str, Any]) -> str:
    """The document as text."""
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _crank(study: TableStudy) -> dict[str, Any] | None:
    if study.crank is None:
        return None
    return {
        "phase_max": study.crank.phase_max,
        "phase_final": study.crank.phase_final,
        "drive_speed": study.crank.speed,
        "drive_acceleration": study.crank.acceleration,
    }


def _estimation(estimation: Estimation) -> dict[str, Any]:
    sense = None
    if estimation.sense is not None:
        value, left, opposite = estimation.sense
        sense = {"value": value, "remaining": left, "remaining_with_opposite": opposite}
    return {
        "estimates": [
            {"name": e.name, "value": e.value, "standard_error": e.error, "unit": e.unit, "meaning": e.meaning}
            for e in estimation.estimates
        ],
        "sense": sense,
        "undetermined": list(estimation.undetermined),
        "rows": estimation.rows,
        "remaining": estimation.remaining,
    }
