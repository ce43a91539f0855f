"""All files of a report on forces, rendered before any is written."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from conrod.report import numbers
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.forces.figure import torque_figure
from conrod.report.forces.page import FILE, INDEX, earlier_scenes, figure_of, force_page, page_of
from conrod.report.forces.words import verdict
from conrod.report.reproduction import Reproduction
from conrod.report.tables import paragraphs, table
from conrod.studies.forces.results import SCHEMA, ForceStudy, force_entry, seen_entry
from conrod.studies.frame.files import Batch

DIGITS, GIVEN_DIGITS = 2, 12
GIVEN = {"parameters", "settings", "revolutions", "tolerance", "change", "stamps"}


def force_report_batch(studies: Sequence[ForceStudy], directory: Path, command: Reproduction) -> Batch:
    """The report: pages and figures of the scenes, a list of all that the folder has, the numbers.

    Scenes that a report in the folder already holds stay in its list.
    """
    files: dict[str, str] = {}
    scenes = earlier_scenes(directory)
    stale = []
    for study in studies:
        alone = command.of(study.name)
        if any(result.curve is not None for result in study.results):
            with drawing_style():
                files[figure_of(study.name)] = svg_text(torque_figure(study))
        elif (directory / figure_of(study.name)).is_file():
            stale.append(figure_of(study.name))
        files[page_of(study.name)] = force_page(study, alone)
        scenes[study.name] = _entry(study, alone)
    document = {"schema": SCHEMA, "force_scenes": scenes}
    files[FILE] = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    files[INDEX] = _index(scenes)
    return Batch(directory, files, tuple(stale))


def _entry(study: ForceStudy, command: str) -> dict[str, Any]:
    results = [force_entry(result) | {"verdict": verdict(result)} for result in study.results]
    entry = {"results": results, "seen": seen_entry(study.seen)}
    about = {"title": study.scene.title, "command": command, "conrod": version("conrod"), "passed": study.passed}
    return {**about, **_rounded(entry)}


def _rounded(value: Any, given: bool = False) -> Any:
    """Two significant digits for what was measured; rounding noise becomes the text that the tables print."""
    match value:
        case float() if not given and abs(value) < numbers.ROUNDING:
            return numbers.BELOW_ROUNDING
        case float():
            return numbers.rounded(value, GIVEN_DIGITS if given else DIGITS)
        case Mapping():
            return {key: _rounded(part, given or key in GIVEN) for key, part in value.items()}
        case list() | tuple():
            return [_rounded(part, given) for part in value]
        case _:
            return value


def _index(scenes: Mapping[str, Any]) -> str:
    rows = [
        [f"[{name}]({page_of(name)})", entry["engine"], entry["preset"], entry["verdict"]]
        for name, scene in sorted(scenes.items())
        for entry in scene["results"]
    ]
    failed = [name for name, scene in sorted(scenes.items()) if not scene["passed"]]
    said = f"**Not passed: {', '.join(failed)}.**" if failed else "**All judged results are within tolerance.**"
    head = ["machine", "engine", "preset", "verdict"]
    about = (
        f"Drive torque, joint reactions and contact forces against the exact ones. [{FILE}]({FILE}) has the numbers."
    )
    return paragraphs("# Forces", about, said, table(head, rows)) + "\n"
