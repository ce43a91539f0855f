"""The report's numbers for machines: `results.json`, from which the index is made too."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from conrod.report import numbers
from conrod.report.verdicts import short_verdict
from conrod.studies.results import Result, SceneStudy
from conrod.studies.serialise import result_entry

SCHEMA = 1
FILE = "results.json"
# Inputs, written as they are; everything else that is a fraction was measured.
INPUTS = {"parameters", "settings", "revolutions"}
INPUT_DIGITS = 12
# What the index reads of an earlier report.
SCENE_KEYS = {"title", "passed", "results"}
ENTRY_KEYS = {"engine", "engine_version", "preset", "steps_per_revolution", "outcome", "verdict"}
ENTRY_KEYS |= {"largest_position_error"}


def scene_summary(study: SceneStudy, command: str) -> dict[str, Any]:
    """The results of one scene, rounded as in the tables."""
    return {
        "title": study.scene.title,
        "command": command,
        "passed": study.passed,
        "results": [_entry(result) for result in study.results],
    }


def _entry(result: Result) -> dict[str, Any]:
    entry = {key: _rounded(value, key in INPUTS) for key, value in result_entry(result).items()}
    return entry | {"verdict": short_verdict(result), "largest_position_error": _rounded(result.largest("position"))}


def _rounded(value: Any, given: bool = False) -> Any:
    """Two significant digits for what was measured; rounding noise becomes the text that the tables print."""
    match value:
        case float() if given:
            return numbers.rounded(value, INPUT_DIGITS)
        case float() if abs(value) < numbers.ROUNDING:
            return numbers.BELOW_ROUNDING
        case float():
            return numbers.rounded(value, 2)
        case Mapping():
            return {key: _rounded(part, given) for key, part in value.items()}
        case list() | tuple():
            return [_rounded(part, given) for part in value]
        case _:
            return value


def earlier_scenes(directory: Path) -> dict[str, Any]:
    """Scenes of the report that a folder already holds; none where it holds no report of this kind."""
    try:
        document = json.loads((directory / FILE).read_text(encoding="utf-8"))
        scenes = document["scenes"] if document["schema"] == SCHEMA else {}
        return {name: s for name, s in scenes.items() if _is_whole(s) and (directory / f"{name}.md").is_file()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def _is_whole(scene: Mapping[str, Any]) -> bool:
    return scene.keys() >= SCENE_KEYS and all(entry.keys() >= ENTRY_KEYS for entry in scene["results"])


def summary_text(scenes: Mapping[str, Any], conrod: str) -> str:
    """The JSON document."""
    document = {"schema": SCHEMA, "conrod": conrod, "scenes": scenes}
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
