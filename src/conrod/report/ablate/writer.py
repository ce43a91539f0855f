"""The report on ingredients: all of it made first, so that it can be put in place together."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from conrod.files import Batch
from conrod.report.ablate.document import Entry, document_text, earlier_ablations, scene_entry
from conrod.report.ablate.figure import ingredients_figure
from conrod.report.ablate.index import ablate_index
from conrod.report.ablate.page import ablate_page
from conrod.report.canvas import drawing_style, svg_text
from conrod.report.reproduction import Reproduction
from conrod.report.summary import FILE, INDEX, figure_file, page_file
from conrod.scenes import SCENES
from conrod.studies.ablate.results import AblationStudy
from conrod.studies.serialise import environment


def ablate_report_batch(studies: Sequence[AblationStudy], directory: Path, command: Reproduction) -> Batch:
    """All files of a report, rendered; nothing is written yet, so that an error leaves an existing one as it was.

    Scenes that such a report in the folder already holds stay in its index, and engines that a study did not look at
    stay on its scene's page. Other files are not touched.

    Args:
        command: what reproduces the report.
    """
    scenes = earlier_ablations(directory)
    made_with = environment()
    for study in studies:
        alone = command.of(study.name)
        scenes[study.name] = scene_entry(study, scenes.get(study.name), made_with, alone)
    return _rendered(directory, document_text(_in_order(scenes)), [study.name for study in studies])


def ablate_report_again(directory: Path) -> Batch:
    """The report that a folder holds, rendered again from its `results.json` alone.

    Raises:
        ValueError: it holds none.
    """
    scenes = earlier_ablations(directory)
    if not scenes:
        raise ValueError(f"{directory} holds no report on ingredients")
    return _rendered(directory, document_text(_in_order(scenes)), list(scenes))


def _rendered(directory: Path, document: str, pages: Collection[str]) -> Batch:
    """The files, made from the document as it is read back: what is drawn is what is kept."""
    scenes: Mapping[str, Entry] = json.loads(document)["ablations"]
    studies = {name: AblationStudy.of(scene["study"]) for name, scene in scenes.items()}
    files: dict[str, str] = {}
    for name in pages:
        drawn = ablate_figures(studies[name])
        files |= {figure_file(name, figure): text for figure, text in drawn.items()}
        files[page_file(name)] = ablate_page(studies[name], scenes[name], drawn)
    files[FILE] = document
    files[INDEX] = ablate_index(scenes, studies)
    return Batch(directory, files, _stale(directory, pages, files))


def ablate_figures(study: AblationStudy) -> dict[str, str]:
    """The SVG figures of a scene by the name of their engine; those of engines that have ingredients."""
    drawn = {}
    with drawing_style():
        for found in study.engines:
            figure = ingredients_figure(found)
            if figure is not None:
                drawn[found.engine] = svg_text(figure)
    return drawn


def _stale(directory: Path, pages: Collection[str], files: Mapping[str, str]) -> tuple[str, ...]:
    """Figures of an earlier page of a scene that the new one does not show: it has other engines."""
    known = earlier_ablations(directory)
    engines = {name: [found["engine"] for found in known[name]["study"]["engines"]] for name in pages if name in known}
    shown = [figure_file(name, engine) for name, found in engines.items() for engine in found]
    return tuple(name for name in shown if name not in files and (directory / name).is_file())


def _in_order(scenes: Mapping[str, Any]) -> dict[str, Any]:
    """The scenes that ship first, in their order."""
    names = [*(name for name in SCENES if name in scenes), *sorted(name for name in scenes if name not in SCENES)]
    return {name: scenes[name] for name in names}
