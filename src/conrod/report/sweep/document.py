"""The sweep's report for machines: `results.json`, from which its index is made too, and it is known by."""

from __future__ import annotations

import json
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from conrod.report import numbers
from conrod.report.folder import check_beside, check_own_folder, document_in, holds_document
from conrod.report.names import FIGURES, FILE, INDEX, figure_file, page_file
from conrod.report.sweep.findings import found_in
from conrod.report.sweep.fronts import TOLERANCES, cheapest_rows
from conrod.studies.sweep.results import SweepStudy

SCHEMA = 1
DRAWN = ("work-precision", "orders", "convergence-index", "budget")
# Inputs, written as they are; everything else that is a fraction was measured.
INPUTS = {"parameters", "settings", "changes", "fixed", "value"}
INPUT_DIGITS, MEASURED_DIGITS = 12, 4
# What the index reads of an earlier report, besides the study itself.
SCENE_KEYS = {"title", "conrod", "command", "findings", "cheapest", "study"}
NESTED = 4  # levels that are written on lines of their own


def scene_entry(study: SweepStudy, command: str) -> dict[str, Any]:
    """What the index says of a scene, and all its numbers."""
    return {
        "title": study.scene.title,
        "conrod": version("conrod"),
        "command": command,
        "findings": found_in(study),
        "cheapest": cheapest_rows(study, "position", TOLERANCES),
        "study": _rounded(_brief(study.as_dict())),
    }


def _brief(study: dict[str, Any]) -> dict[str, Any]:
    """Without what the rest tells: a point's rule and steps are its settings, shares sum up the triples of grids.

    `conrod sweep --json` and the ledger have them.
    """
    points = [{name: part for name, part in point.items() if name != "settings"} for point in study["points"]]
    found = {
        name: [{part: value for part, value in family.items() if part != "triples"} for family in study[name]]
        for name in ("grid_convergence", "both_ways")
    }
    return {**study, "points": points, **found}


def document_text(scenes: Mapping[str, Any], transfers: Sequence[Mapping[str, Any]]) -> str:
    """The JSON document: a point, a path or a budget a line."""
    document = {"schema": SCHEMA, "sweeps": scenes, "transfers": [_rounded(found) for found in transfers]}
    return _lines(document, 0) + "\n"


def _rounded(value: Any, given: bool = False) -> Any:
    """Four significant digits for what was measured; what is not finite becomes the text that the tables print."""
    match value:
        case float() if not math.isfinite(value):
            return numbers.measured(value)
        case float():
            return numbers.rounded(value, INPUT_DIGITS if given else MEASURED_DIGITS)
        case Mapping():
            return {str(key): _rounded(part, given or key in INPUTS) for key, part in value.items()}
        case list() | tuple():
            return [_rounded(part, given) for part in value]
        case _:
            return value


def _lines(value: Any, level: int) -> str:
    """JSON with a line for each part of the first levels, and all below them in one line."""
    if level >= NESTED or not isinstance(value, Mapping | list) or not value:
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    margin = " " * (level + 1)
    if isinstance(value, Mapping):
        parts = [f"{json.dumps(str(k), ensure_ascii=False)}: {_lines(v, level + 1)}" for k, v in value.items()]
        opening, closing = "{", "}"
    else:
        parts = [_lines(part, level + 1) for part in value]
        opening, closing = "[", "]"
    inside = ",\n".join(margin + part for part in parts)
    return f"{opening}\n{inside}\n{' ' * level}{closing}"


# -- the report that a folder holds ----------------------------------------------------------------------------------


def earlier_sweeps(directory: Path) -> dict[str, Any]:
    """Scenes of the sweep report that a folder already holds; none where it holds no report of this kind."""
    try:
        document = document_in(directory / FILE)
        scenes = document["sweeps"] if document["schema"] == SCHEMA else {}
        whole = {name: scene for name, scene in scenes.items() if scene.keys() >= SCENE_KEYS}
        return {name: scene for name, scene in whole.items() if (directory / page_file(name)).is_file()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def check_sweep_folder(directory: Path, scenes: Collection[str]) -> None:
    """Refuse a folder in which a report of a sweep of some scenes would replace what is not such a report's.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    pages = [INDEX, FILE, *(page_file(scene) for scene in scenes)]
    drawn = [figure_file(scene, figure) for scene in scenes for figure in DRAWN]
    own = holds_document(directory / FILE, {"schema", "sweeps"})
    check_own_folder(directory, pages, drawn, FIGURES, own, "a sweep's report")


def check_sweep_apart(document: Path, directory: Path, scenes: Iterable[str]) -> None:
    """Refuse a file that is one of those that a report of a sweep of some scenes consists of, or is in its way.

    Raises:
        InvalidInput: names the file.
    """
    pages = [page_file(scene) for scene in (*scenes, *earlier_sweeps(directory))]
    # Its folder of figures is the report's own.
    check_beside(document, directory, [INDEX, FILE, *pages, f"{FIGURES}/{document.name}"])
