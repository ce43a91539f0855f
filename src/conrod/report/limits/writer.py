"""The report of limits: all of it made first, so that it can be put in place together."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from conrod.files import Batch
from conrod.report.limits.document import Entry, document_text, earlier_gallery, earlier_limits, scene_entry
from conrod.report.limits.figures import limits_figures
from conrod.report.limits.index import limits_index
from conrod.report.limits.page import limits_page
from conrod.report.limits.words import readable
from conrod.report.pages import FIGURES
from conrod.report.reproduction import Reproduction
from conrod.report.summary import FILE, INDEX, figure_file, page_file
from conrod.scenes import SCENES
from conrod.studies.limits.gallery import Exhibit
from conrod.studies.limits.study import LimitStudy
from conrod.studies.serialise import environment

SHOWN_FIGURE = re.compile(rf"\]\(({FIGURES}/[^)/]+\.svg)\)")


def limits_report_batch(
    studies: Sequence[LimitStudy],
    gallery: Sequence[Exhibit],
    directory: Path,
    command: Reproduction,
) -> Batch:
    """All files of a report of limits, rendered; nothing is written yet, so an error leaves an existing one as it was.

    Scenes that such a report in the folder already holds stay in its index, and what a study did not look at stays on
    its scene's page. Other files are not touched.

    Args:
        gallery: a run for each way of ending; without any the folder's own stays.
        command: what reproduces the report.
    """
    scenes = earlier_limits(directory)
    made_with = environment()
    for study in studies:
        alone = command.of(study.name)
        scenes[study.name] = scene_entry(study, scenes.get(study.name), made_with, alone)
    shown = [one.as_dict() for one in gallery] or earlier_gallery(directory)
    return _rendered(directory, document_text(_in_order(scenes), shown), [study.name for study in studies])


def limits_report_again(directory: Path) -> Batch:
    """The report that a folder holds, rendered again from its `results.json` alone.

    Raises:
        ValueError: it holds none.
    """
    scenes = earlier_limits(directory)
    if not scenes:
        raise ValueError(f"{directory} holds no report of limits")
    return _rendered(directory, document_text(_in_order(scenes), earlier_gallery(directory)), list(scenes))


def _rendered(directory: Path, document: str, pages: Collection[str]) -> Batch:
    """The files, made from the document as it is read back: what is drawn is what is kept."""
    kept = json.loads(document)
    scenes: Mapping[str, Entry] = kept["limits"]
    studies = {name: _readable(LimitStudy.of(scene["study"])) for name, scene in scenes.items()}
    files: dict[str, str] = {}
    for name in pages:
        drawn = limits_figures(studies[name])
        files |= {figure_file(name, figure): text for figure, text in drawn.items()}
        files[page_file(name)] = limits_page(studies[name], scenes[name], drawn)
    files[FILE] = document
    files[INDEX] = limits_index(scenes, studies, [Exhibit.of(one) for one in kept["gallery"]])
    return Batch(directory, files, _stale(directory, pages, files))


def _readable(study: LimitStudy) -> LimitStudy:
    needs = (replace(need, walks=tuple(map(readable, need.walks))) for need in study.needs)
    return replace(study, walks=tuple(map(readable, study.walks)), needs=tuple(needs))


def _stale(directory: Path, pages: Collection[str], files: Mapping[str, str]) -> tuple[str, ...]:
    """Figures that the earlier page of a scene showed and the new one does not."""
    earlier = [directory / page_file(name) for name in pages if (directory / page_file(name)).is_file()]
    shown = dict.fromkeys(name for page in earlier for name in SHOWN_FIGURE.findall(page.read_text(encoding="utf-8")))
    return tuple(name for name in shown if name not in files and (directory / name).is_file())


def _in_order(scenes: Mapping[str, Any]) -> dict[str, Any]:
    """The scenes that ship first, in their order."""
    names = [*(name for name in SCENES if name in scenes), *sorted(name for name in scenes if name not in SCENES)]
    return {name: scenes[name] for name in names}
