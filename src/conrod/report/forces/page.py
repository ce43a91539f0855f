"""The files of a report on forces: in a folder of their own, or beside the report on motion.

A scene's page on its forces in Markdown.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.folder import check_beside, check_own_folder, document_in, holds_document
from conrod.report.forces.words import (
    BLIND,
    CONTACT,
    ERRORS,
    MASSES,
    NOTHING_BLIND,
    STAMPS,
    blind_words,
    change_words,
    property_words,
    reasons,
    stamps_words,
    untold_words,
    verdict,
)
from conrod.report.tables import bullets, paragraphs, table
from conrod.studies.forces.exact import GROUPS, is_moment
from conrod.studies.forces.results import ForceResult, ForceStudy
from conrod.studies.forces.seen import Effect

FIGURES, FILE, INDEX = "figures", "forces.json", "forces.md"
KEYS = {"schema", "force_scenes"}


def page_of(scene: str) -> str:
    """Name of a scene's page."""
    return f"{scene}-forces.md"


def figure_of(scene: str) -> str:
    """Name of a scene's figure."""
    return f"{FIGURES}/{scene}-torque.svg"


def index_of(scenes: Sequence[str]) -> str:
    """The page to read first: that of the scene, or the list of several."""
    return page_of(scenes[0]) if len(scenes) == 1 else INDEX


def check_force_files(directory: Path, scenes: Collection[str], document: Path | None) -> None:
    """Refuse what the report would replace that is not its own, and a document that is a file of it.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    own = holds_document(directory / FILE, KEYS)
    pages = [INDEX, FILE, *(page_of(scene) for scene in scenes)]
    drawn = [figure_of(scene) for scene in scenes]
    check_own_folder(directory, pages, drawn, FIGURES, own, "a report on forces")
    if document:
        check_beside(document, directory, [*pages, *drawn])


def earlier_scenes(directory: Path) -> dict[str, Any]:
    """Scenes of the report on forces that a folder already holds, by name."""
    try:
        scenes = document_in(directory / FILE)["force_scenes"]
        return {name: entry for name, entry in scenes.items() if (directory / page_of(name)).is_file()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}


def force_page(study: ForceStudy, command: str) -> str:
    """The page of one scene.

    Args:
        command: what reproduces the page.
    """
    told = [r for r in study.results if r.errors]
    drawn = any(r.curve is not None for r in told)
    versions = dict.fromkeys(f"{engine_title(r.engine)} {r.engine_version}" for r in study.results)
    blocks = [
        f"# {study.name}: forces",
        f"{study.scene.title}, driven at constant speed. Source: {study.scene.source}.",
        f"Reproduced by `{command}`, with {', '.join(versions)}.",
        "## Verdict",
        _verdicts(study),
        bullets(reasons(study.results)),
        bullets(f"{_name(r)}: {words}" for r in study.results if r.outcome == "completed" for words in untold_words(r)),
        f"![Drive torque over the crank angle, exact and by engines, and its error]({figure_of(study.name)})"
        if drawn
        else "",
        "## Errors",
        ERRORS,
        CONTACT if study.scene.kinematics.mechanism.cam_contacts else "",
        *(_errors(study, group, told) for group in GROUPS),
        "## Order of convergence",
        _orders(told),
        "## When values are valid",
        STAMPS,
        table(["engine", "preset", "values"], [[*_two(r), stamps_words(r.stamps)] for r in told]),
        "## What a wrong mass does",
        _masses(study),
    ]
    return paragraphs(*blocks) + "\n"


def _two(result: ForceResult) -> list[str]:
    return [engine_title(result.engine), result.preset]


def _name(result: ForceResult) -> str:
    return " ".join(_two(result))


def _verdicts(study: ForceStudy) -> str:
    groups = _groups(study.results)
    rows = [
        [*_two(r), str(r.steps_per_revolution)]
        + [numbers.measured(r.judged(g)) for g in groups]
        + [numbers.order((r.order or {}).get(g)) for g in groups]
        + [verdict(r)]
        for r in study.results
    ]
    head = ["engine", "preset", "steps per revolution", *groups, *(f"order of {g}" for g in groups), "verdict"]
    return table(head, rows)


def _groups(results: Sequence[ForceResult]) -> list[str]:
    return [g for g in GROUPS if any(g in r.groups for r in results)]


def _errors(study: ForceStudy, group: str, told: Sequence[ForceResult]) -> str:
    """A row for each quantity, joint by joint, with max and rms of each run."""
    names = next((r.groups[group] for r in told if group in r.groups), ())
    rows = []
    for name in names:
        some = [r.errors[name] for r in told if r.errors and name in r.errors]
        if not some:
            rows.append([f"`{name}`", numbers.MISSING, *(["unsupported"] * len(told))])
            continue
        first = some[0]
        unit = "N m" if is_moment(name) else "N"
        peak = f"{numbers.quantity(first.peak)} {unit}" + ("" if first.own_peak else " (of others)")
        rows.append([f"`{name}`", peak, *(_sizes(r, name) for r in told)])
    return table(["quantity", "exact peak", *(f"{_name(r)}: max, rms" for r in told)], rows)


def _sizes(result: ForceResult, name: str) -> str:
    one = (result.errors or {}).get(name)
    if one is None:
        return "unsupported"
    between = "" if one.between is None else f"; {numbers.measured(one.between)} between arc joints"
    return f"{numbers.measured(one.max)}, {numbers.measured(one.rms)}{between}"


def _orders(told: Sequence[ForceResult]) -> str:
    runs = [r for r in told if r.refinement]
    steps = sorted({p.steps_per_revolution for r in runs for p in r.refinement})
    rows = []
    for run in runs:
        by_steps = {p.steps_per_revolution: p for p in run.refinement}
        for group, names in run.groups.items():
            cells = []
            for n in steps:
                point = by_steps.get(n)
                sizes = [] if point is None else [point.errors[k] for k in names if k in point.errors]
                ended = "" if point is None or point.outcome == "completed" else f" ({point.outcome})"
                cells.append(numbers.measured(max(sizes) if sizes else None) + ended)
            rows.append([*_two(run), group, *cells, numbers.order((run.order or {}).get(group))])
    return table(["engine", "preset", "largest of", *(f"N = {n}" for n in steps), "order"], rows)


def _masses(study: ForceStudy) -> str:
    seen = study.seen
    if not seen.effects:
        return "Nothing was looked at."
    judged = [r for r in study.results if r.likeness is not None and r.tolerance]
    rows = [
        [
            effect.body,
            property_words(effect.quality),
            change_words(effect.quality, effect.change),
            "none" if effect.unseen else f"`{effect.quantity}`",
            numbers.measured(None if effect.unseen else effect.effect),
            *(_likeness(r, effect) for r in judged),
        ]
        for effect in seen.effects
    ]
    head = ["body", "property", "change", "shown most by", "by, of its peak", *(_name(r) for r in judged)]
    together = blind_words(seen)
    return paragraphs(MASSES, table(head, rows), BLIND if together else NOTHING_BLIND, bullets(together))


def _likeness(result: ForceResult, effect: Effect) -> str:
    """How many such changes a run's errors look like."""
    times = (result.likeness or {}).get(f"{effect.body}.{effect.quality}")
    return numbers.MISSING if times is None else numbers.measured(times)
