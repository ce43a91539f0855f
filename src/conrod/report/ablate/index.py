"""The first page of a report on ingredients."""

from __future__ import annotations

from collections.abc import Mapping

from conrod.report import numbers
from conrod.report.ablate import prose, words
from conrod.report.ablate.document import Entry
from conrod.report.origin import told_origin
from conrod.report.styles import engine_title
from conrod.report.tables import paragraphs, table
from conrod.studies.ablate.results import AblationStudy, EngineAblation, IngredientResult
from conrod.studies.ablate.variants import Role
from conrod.studies.ablate.verdict import JUDGED

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
