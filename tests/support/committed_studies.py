"""Committed studies of limits and of ingredients: whole, in part, and as they would be had every engine warned."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

from conrod.report.folder import restore_findings
from conrod.studies.ablate.findings import AblationStudy
from conrod.studies.limits.results import LimitStudy, Walk

SCENE = "saw-500rpm"
REPORTS = Path(__file__).parents[2] / "reports"


@cache
def ablation_study() -> AblationStudy:
    """In one engine."""
    return restore_findings(AblationStudy, json.loads((REPORTS / "ablate" / "data" / f"{SCENE}.json").read_text()))


@cache
def limit_study() -> LimitStudy:
    """A few axes, and one or two of every other part."""
    study = restore_findings(LimitStudy, json.loads((REPORTS / "limits" / "data" / f"{SCENE}.json").read_text()))
    shown = ("steps", "mass-ratio", "regularisation", "start-pose", "float")
    walks = tuple(walk for walk in study.walks if walk.axis in shown)
    return replace(study, walks=walks, maps=study.maps[:1], determinism=study.determinism[:2])


def of_axis(axis: str) -> LimitStudy:
    """What asking for one axis alone would have given."""
    walks = tuple(walk for walk in limit_study().walks if walk.axis == axis)
    return replace(limit_study(), walks=walks, maps=(), determinism=(), floats=())


def with_all_detected(walks: Sequence[Walk]) -> tuple[Walk, ...]:
    """The same walks, had every engine warned."""
    return tuple(replace(w, probes=tuple(replace(p, undetected=False) for p in w.probes)) for w in walks)
