"""What was found of a user's model as plain values: SI, radians and normalised errors."""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

from conrod.own.models.identity import Identity
from conrod.own.models.lengths import Explanation
from conrod.own.models.runs import QUANTITIES, JudgedRun
from conrod.own.models.study import ModelStudy
from conrod.studies.validation.serialise import environment

MEASURES = ("max", "rms", "final")
KEYS = {"conrod", "model", "machine", "identity", "runs"}


def model_document(study: ModelStudy) -> dict[str, Any]:
    """The whole study; a report and its folder are known by its keys."""
    scan = study.scan
    return {
        "conrod": version("conrod"),
        "environment": environment(),
        "model": {
            "file": study.file,
            "name": scan.name,
            "crank": study.question.crank,
            "points": {place.point: str(place) for place in study.question.places},
            "joints": dict(scan.wiring.joints),
            "closures": dict(scan.wiring.closures),
            "redundant": list(scan.wiring.idle),
            "inactive": list(scan.wiring.inactive),
            "coordinates": scan.wiring.coordinates,
            "rank": list(scan.wiring.rank),
            "loops": scan.wiring.loops,
            "closure_gap": scan.gap,
            "settings": vars(scan.settings) | {"gravity": list(scan.settings.gravity)},
            "stops": list(scan.stops),
            "remarks": list(scan.remarks),
        },
        "machine": {"scene": study.scene_name, "parameters": study.scene.parameters},
        "identity": _identity(study.identity),
        "is_machine": study.is_machine,
        "passed": study.passed,
        "tolerance": None if study.tolerance is None else dict(study.tolerance),
        "kinematic_tolerance": study.kinematic_tolerance,
        "revolutions": study.revolutions,
        "compared_at": list(study.points),
        "runs": {label: _run(run) for label, run in study.runs.items()},
        "refused": dict(study.refused),
        "drive_share": None if study.drive_share is None else dict(study.drive_share),
    }


def _identity(identity: Identity) -> dict[str, Any]:
    frame, given = identity.frame, vars(identity.given)
    return {
        "frame": {
            "plane": frame.view.name,
            "right": list(frame.view.right),
            "up": list(frame.view.up),
            "rotation": frame.rotation,
            "crank_zero": frame.zero,
            "sense": frame.sense,
            "length_unit": frame.unit,
            "crank_axis": list(frame.anchor),
        },
        "given": sorted(name for name, value in given.items() if value is not None),
        "other_branch": identity.other_branch,
        "position": identity.off_by,
        "rate": identity.rate_off,
        "floor": identity.floor,
        "unexplained": identity.left,
        "explanations": [_explanation(e) for e in identity.explanations],
        "closest": None if identity.closest is None else _explanation(identity.closest),
        "indistinct": [list(group) for group in identity.indistinct],
    }


def _explanation(found: Explanation) -> dict[str, Any]:
    return {
        "lengths": {one.name: {"wanted": one.wanted, "found": one.found} for one in found.lengths},
        "misplaced": {one.point: one.away for one in found.misplaced},
        "left": found.left,
    }


def _run(run: JudgedRun) -> dict[str, Any]:
    errors = None
    if run.errors is not None:
        errors = {
            name: {
                quantity: {m: getattr(getattr(of_point, quantity).size, m) for m in MEASURES}
                for quantity in (*QUANTITIES, "total")
            }
            for name, of_point in run.errors.items()
        }
    completed = run.errors is not None
    return {
        "outcome": run.outcome.slug,
        "reason": run.reason or None,
        "armature": run.armature,
        "steps_per_revolution": run.steps_per_revolution,
        "errors": errors,
        "ripple": run.ripple if completed else None,
        "phase": run.phase if completed else None,
        "closure_gap": run.gap if completed else None,
        "warnings": dict(run.warnings),
    }
