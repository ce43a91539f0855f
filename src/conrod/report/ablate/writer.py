"""The first page of a report on ingredients.

The report on ingredients: all of it made first, so that it can be put in place together.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from conrod.report import numbers
from conrod.report.ablate import words
from conrod.report.ablate import words as prose
from conrod.report.ablate.document import Entry, document_text, earlier_ablations, scene_entry
from conrod.report.ablate.figure import ingredients_figure
from conrod.report.ablate.page import ablate_page
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.charts.styles import engine_title
from conrod.report.names import FILE, INDEX, figure_file, page_file
from conrod.report.reproduction import Reproduction, told_origin
from conrod.report.tables import paragraphs, table
from conrod.scenes import SCENES
from conrod.studies.ablate.plan import Role
from conrod.studies.ablate.results import AblationStudy, EngineAblation, IngredientResult
from conrod.studies.ablate.verdict import JUDGED
from conrod.studies.frame.files import Batch
from conrod.studies.validation.serialise import environment

Studies = Mapping[str, AblationStudy]
ABSENT = "-"


def ablate_index(scenes: Mapping[str, Entry], studies: Studies) -> str:
    """The index.

    Args:
        scenes: entries of the document, by name.
        studies: what they hold.
    """
    engines = list(dict.fromkeys(found.engine for study in studies.values() for found in study.engines))
    blocks = [
        "# What a model needs",
        prose.PURPOSE,
        "\n".join(f"- [{name}]({name}.md): {study.title}" for name, study in studies.items()),
        "## The minimal model against the fully dressed one",
        _headline(studies),
        "## Verdicts",
        prose.VERDICTS,
        *(block for engine in engines for block in _verdicts(engine, studies)),
        "## Made with",
        _made_with(scenes, studies),
        f"{told_origin(scenes)} [results.json](results.json) holds every figure.",
    ]
    return paragraphs(*blocks) + "\n"


def _headline(studies: Studies) -> str:
    head = ["machine", "engine", "fully dressed over minimal, CPU time", "largest difference of the observed position"]
    head += ["largest error of the minimal model", "of the fully dressed one"]
    rows = [_dressed(name, found) for name, study in studies.items() for found in study.engines]
    return table(head, rows)


def _dressed(name: str, found: EngineAblation) -> list[str]:
    minimal, dressed = found.variant(Role.MINIMAL.value), found.variant(Role.DRESSED.value)
    first = [f"[{name}]({name}.md)", engine_title(found.engine)]
    if minimal is None or dressed is None:
        return [*first, *[ABSENT] * 4]
    return [
        *first,
        words.cost_text(dressed.cost),
        words.change_text(dressed.change),
        *(_position(variant.errors) if variant.completed else f"`{variant.outcome}`" for variant in (minimal, dressed)),
    ]


def _position(errors: Mapping[str, float] | None) -> str:
    return numbers.measured(None if errors is None else errors[JUDGED[0]])


def _verdicts(engine: str, studies: Studies) -> list[str]:
    """A row for each ingredient, a column for each machine."""
    found = {name: one for name, study in studies.items() for one in study.engines if one.engine == engine}
    names = dict.fromkeys(one.name for engine_found in found.values() for one in engine_found.ingredients)
    rows = []
    for name in names:
        own = {scene: _ingredient(engine_found, name) for scene, engine_found in found.items()}
        known = [one for one in own.values() if one is not None]
        needs = dict.fromkeys(need for one in known for need in words.needs_of(one))
        verdicts = [ABSENT if one is None else one.verdict for one in own.values()]
        rows.append([f"`{name}`", known[0].title, *verdicts, ", ".join(needs)])
    body = table(["ingredient", "in words", *found, "needed by studies of"], rows)
    return [f"### {engine_title(engine)}", body] if body else []


def _ingredient(found: EngineAblation, name: str) -> IngredientResult | None:
    return next((one for one in found.ingredients if one.name == name), None)


def _made_with(scenes: Mapping[str, Entry], studies: Studies) -> str:
    """All versions that occur: scenes that were looked at earlier stay as they were."""
    found: dict[str, set[str]] = {"conrod": {scene["conrod"] for scene in scenes.values()}}
    for study in studies.values():
        for one in study.engines:
            found.setdefault(engine_title(one.engine), set()).add(one.version)
            found.setdefault("costs taken on", set()).add(one.machine)
    shown = {one.engine for study in studies.values() for one in study.engines}
    for scene in scenes.values():
        for name, version in scene["environment"].items():
            if name not in shown:
                found.setdefault(name, set()).add(version)
    return table(["what", "which"], [[name, "; ".join(sorted(versions))] for name, versions in found.items()])


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
