"""The first page of a report of limits: the dangerous runs of all machines first.

The report of limits: all of it made first, so that it can be put in place together.
"""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from conrod.report.charts.styles import engine_title
from conrod.report.limits import prose
from conrod.report.limits.document import Entry, document_text, earlier_limits, scene_entry
from conrod.report.limits.figures import limits_figures
from conrod.report.limits.findings import findings
from conrod.report.limits.other_tables import determinism_table, long_run_table, steps_table
from conrod.report.limits.page import limits_page
from conrod.report.limits.undetected_table import quiet_elsewhere, quiet_summary
from conrod.report.limits.words import readable
from conrod.report.names import FIGURES, FILE, INDEX, figure_file, page_file
from conrod.report.reproduction import Reproduction, told_origin
from conrod.report.tables import paragraphs, table
from conrod.runs.plain import restore
from conrod.scenes import SCENES
from conrod.studies.frame.files import Batch
from conrod.studies.limits.results import LimitStudy
from conrod.studies.validation.serialise import environment

Studies = Mapping[str, LimitStudy]


def limits_index(scenes: Mapping[str, Entry], studies: Studies) -> str:
    """The index.

    Args:
        scenes: entries of the document, by name.
        studies: what they hold.
    """
    walks = [walk for study in studies.values() for walk in study.walks]
    dangers = quiet_summary(walks)
    elsewhere = "\n".join(f"- {name}: {told}" for name, study in studies.items() if (told := quiet_elsewhere(study)))
    steps = steps_table(walks)
    same = determinism_table([found for study in studies.values() for found in study.determinism], with_scene=True)
    long = long_run_table([run for study in studies.values() for run in study.long_runs], with_scene=True)
    blocks = [
        "# Limits",
        prose.PURPOSE,
        "\n".join(f"- [{name}]({name}.md): {study.title}" for name, study in studies.items()),
        "## Wrong, and nothing says so",
        prose.WORDS,
        prose.QUIET if dangers or elsewhere else prose.NO_QUIET,
        dangers,
        elsewhere,
        "## What was found",
        *(block for name, study in studies.items() for block in _findings(name, study)),
        *(["## Steps per revolution", prose.STEPS, steps] if steps else []),
        *(["## The same again?", prose.DETERMINISM, same] if same else []),
        *(["## Long runs", prose.LONG_RUNS, long] if long else []),
        "## Made with",
        _made_with(scenes, studies),
        f"{told_origin(scenes)} [results.json](results.json) holds every run.",
    ]
    return paragraphs(*blocks) + "\n"


def _findings(name: str, study: LimitStudy) -> list[str]:
    found = findings(study.walks)
    return [f"### [{name}]({name}.md)", "\n".join(f"- {text}" for text in found)] if found else []


def _made_with(scenes: Mapping[str, Entry], studies: Studies) -> str:
    """All versions that occur: scenes that were looked at earlier stay as they were."""
    found: dict[str, set[str]] = {"conrod": {scene["conrod"] for scene in scenes.values()}}
    for study in studies.values():
        for engine, version in study.engines.items():
            found.setdefault(engine_title(engine), set()).add(version)
    shown = {engine for study in studies.values() for engine in study.engines}
    for scene in scenes.values():
        for name, version in scene["environment"].items():
            if name not in shown:
                found.setdefault(name, set()).add(version)
    return table(["what", "which"], [[name, "; ".join(sorted(versions))] for name, versions in found.items()])


SHOWN_FIGURE = re.compile(rf"\]\(({FIGURES}/[^)/]+\.svg)\)")


def limits_report_batch(
    studies: Sequence[LimitStudy],
    directory: Path,
    command: Reproduction,
) -> Batch:
    """All files of a report of limits, rendered; nothing is written yet, so an error leaves an existing one as it was.

    Scenes that such a report in the folder already holds stay in its index, and what a study did not look at stays on
    its scene's page. Other files are not touched.

    Args:
        command: what reproduces the report.
    """
    scenes = earlier_limits(directory)
    made_with = environment()
    for study in studies:
        alone = command.of(study.name)
        scenes[study.name] = scene_entry(study, scenes.get(study.name), made_with, alone)
    return _rendered(directory, document_text(_in_order(scenes)), [study.name for study in studies])


def limits_report_again(directory: Path) -> Batch:
    """The report that a folder holds, rendered again from its `results.json` alone.

    Raises:
        ValueError: it holds none.
    """
    scenes = earlier_limits(directory)
    if not scenes:
        raise ValueError(f"{directory} holds no report of limits")
    return _rendered(directory, document_text(_in_order(scenes)), list(scenes))


def _rendered(directory: Path, document: str, pages: Collection[str]) -> Batch:
    """The files, made from the document as it is read back: what is drawn is what is kept."""
    kept = json.loads(document)
    scenes: Mapping[str, Entry] = kept["limits"]
    studies = {name: _readable(restore(LimitStudy, scene["study"])) for name, scene in scenes.items()}
    files: dict[str, str] = {}
    for name in pages:
        drawn = limits_figures(studies[name])
        files |= {figure_file(name, figure): text for figure, text in drawn.items()}
        files[page_file(name)] = limits_page(studies[name], scenes[name], drawn)
    files[FILE] = document
    files[INDEX] = limits_index(scenes, studies)
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
