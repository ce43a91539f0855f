"""Results of a validation of forces as JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from conrod.studies.forces.results import ForceResult, ForceStudy
from conrod.studies.forces.seen import Seen
from conrod.studies.serialise import environment

SCHEMA = 1


def forces_document(studies: Sequence[ForceStudy]) -> dict[str, Any]:
    """The document that `conrod validate --quantity ... --json` writes; what is not available is None."""
    return {
        "schema": SCHEMA,
        "conrod": version("conrod"),
        "environment": environment(),
        "forces": [force_entry(result) for study in studies for result in study.results],
        "seen": {study.name: seen_entry(study.seen) for study in studies},
    }


def forces_text(studies: Sequence[ForceStudy]) -> str:
    """The same as text."""
    return json.dumps(forces_document(studies), indent=1, allow_nan=False) + "\n"


def force_entry(result: ForceResult) -> dict[str, Any]:
    """One result as plain values: errors over peaks, peaks in N and N m, without the curve."""
    return {
        "scene": result.scene,
        "parameters": dict(result.parameters),
        "engine": result.engine,
        "engine_version": result.engine_version,
        "preset": result.preset,
        "settings": None if result.settings is None else dict(result.settings),
        "steps_per_revolution": result.steps_per_revolution,
        "revolutions": result.revolutions,
        "outcome": result.outcome,
        "reason": result.reason or None,
        "stamps": None if result.stamps is None else asdict(result.stamps),
        "largest": {group: result.judged(group) for group in result.groups},
        "errors": None if result.errors is None else {name: asdict(one) for name, one in result.errors.items()},
        "unsupported": dict(result.unsupported or {}),
        "order": None if result.order is None else dict(result.order),
        "refinement": [asdict(point) for point in result.refinement] or None,
        "tolerance": dict(result.tolerance) if result.tolerance else None,
        "tolerance_reason": result.reason_of_tolerance or None,
        "likeness": None if result.likeness is None else dict(result.likeness),
        "passed": result.passed,
    }


def seen_entry(seen: Seen) -> dict[str, Any]:
    """What the quantities see of a wrong mass."""
    return {
        "effects": [asdict(effect) | {"unseen": effect.unseen} for effect in seen.effects],
        "blind": [{f"{body}.{name}": v for (body, name), v in blind.shares.items()} for blind in seen.blind],
    }
