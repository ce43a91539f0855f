"""The report's numbers for machines: `results.json`, from which the index is made too, and a report is known by."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from conrod.report import numbers
from conrod.report.charts.styles import FIGURE_NAMES
from conrod.report.folder import check_beside, check_own_folder, document_in, holds_document
from conrod.report.validation.pages import FIGURES
from conrod.report.validation.verdicts import short_verdict
from conrod.studies.validation.results import Result, SceneStudy
from conrod.studies.validation.serialise import result_entry

SCHEMA = 1
FILE = "results.json"
INDEX = "README.md"
# Inputs, written as they are; everything else that is a fraction was measured.
INPUTS = {"parameters", "settings", "revolutions"}
INPUT_DIGITS = 12
# Said of scenes whose exact motion is not known in closed form.
GENERIC_RULER = "generic solver"
# What the index reads of an earlier report.
SCENE_KEYS = {"title", "passed", "results"}
ENTRY_KEYS = {"engine", "engine_version", "preset", "steps_per_revolution", "outcome", "verdict"}
ENTRY_KEYS |= {"largest_position_error"}


def scene_summary(study: SceneStudy, command: str) -> dict[str, Any]:
    """The results of one scene, rounded as in the tables."""
    return {
        "title": study.scene.title,
        "command": command,
        "conrod": version("conrod"),
        "passed": study.passed,
        **({} if study.scene.closed_form else {"source": study.scene.source, "ruler": GENERIC_RULER}),
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


# -- the report that a folder holds ----------------------------------------------------------------------------------


def earlier_scenes(directory: Path) -> dict[str, Any]:
    """Scenes of the report that a folder already holds; none where it holds no report of this kind."""
    try:
        document = document_in(directory / FILE)
        scenes = document["scenes"] if document["schema"] == SCHEMA else {}
        # Before scenes named the version that they were measured with, the document alone did.
        default = document.get("conrod", "unknown")
        whole = {n: {**s, "conrod": s.get("conrod", default)} for n, s in scenes.items() if _is_whole(s)}
        return {name: s for name, s in whole.items() if (directory / page_file(name)).is_file()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def _is_whole(scene: Mapping[str, Any]) -> bool:
    return scene.keys() >= SCENE_KEYS and all(entry.keys() >= ENTRY_KEYS for entry in scene["results"])


def page_file(scene: str) -> str:
    """Name of a scene's page in the report's folder."""
    return f"{scene}.md"


def figure_file(scene: str, figure: str) -> str:
    """Name of a scene's figure in the report's folder."""
    return f"{FIGURES}/{scene}-{figure}.svg"


def check_report_folder(directory: Path, scenes: Collection[str]) -> None:
    """Refuse a folder in which a report of some scenes would replace what is not a report's.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    pages = [INDEX, FILE, *(page_file(scene) for scene in scenes)]
    own = holds_document(directory / FILE, {"schema", "scenes"})
    check_own_folder(directory, pages, _figures(scenes), FIGURES, own, "a conrod report")


def check_apart(document: Path, directory: Path, scenes: Iterable[str]) -> None:
    """Refuse a file that is one of those that a report of some scenes consists of, or stands in its folder's way.

    Raises:
        InvalidInput: names the file.
    """
    scenes = {*scenes, *earlier_scenes(directory)}
    pages = [INDEX, FILE, *(page_file(scene) for scene in scenes)]
    check_beside(document, directory, [*pages, *_figures(scenes)])


def _figures(scenes: Iterable[str]) -> list[str]:
    return [figure_file(scene, figure) for scene in scenes for figure in FIGURE_NAMES]


def summary_text(scenes: Mapping[str, Any], conrod: str) -> str:
    """The JSON document."""
    document = {"schema": SCHEMA, "conrod": conrod, "scenes": scenes}
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
