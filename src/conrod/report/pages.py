"""A scene's page in Markdown."""

from __future__ import annotations

from conrod.report import numbers, prose, sections
from conrod.report.settings_table import settings
from conrod.report.styles import completed, engine_title
from conrod.report.tables import paragraphs
from conrod.scenes import Scene
from conrod.studies.results import SceneStudy

FIGURES = "figures"


def scene_page(study: SceneStudy, command: str) -> str:
    """The page of one scene.

    Args:
        command: what reproduces the page.
    """
    scene = study.scene
    blocks = [
        f"# {study.name}: {scene.title}",
        scene.description.format(**_in_words(scene)),
        f"Source: {scene.source}.",
        f"Reproduced by `{command}`, with {versions(study)}. See the [index](README.md) for the other machines.",
        "## Verdict",
        summary(study),
        sections.verdicts(study),
        prose.PRESETS,
        "## Mechanism",
        figure(study, "mechanism", f"The mechanism of {study.name} with its dimensions"),
        f"Frame: {scene.frame}",
        sections.parameters(study),
        prose.MASSES,
        "## Proof of the model: kinematic mode",
        sections.kinematic(study),
        *_measured(study),
        sections.printed_table(study),
        sections.cam(study),
        "## Tolerances",
        sections.tolerances(study),
        "## Settings",
        settings(study),
        "## What this comparison cannot see",
        sections.blind_spots(study),
    ]
    return paragraphs(*blocks) + "\n"


def _measured(study: SceneStudy) -> list[str]:
    """The sections that need at least one run that completed."""
    runs = completed(study.results)
    if not runs:
        return ["## Errors", "No run completed, so there are no errors to show."]
    revolutions = numbers.quantity(runs[0].revolutions)
    blocks = [
        "## Motion",
        f"Over the last of {revolutions} revolutions.",
        figure(study, "motion", "Position, velocity and acceleration of the engines over the exact curve"),
        "## Errors",
        figure(study, "error", "Error of every run against the crank angle"),
        f"The largest error over the observed points, over {revolutions} revolutions; arrow heads at the right edge "
        "are tolerances of the run of the same colour and fill.",
        sections.errors(study),
    ]
    if any(run.refinement for run in runs):
        blocks += ["## Order of convergence", figure(study, "order", "Error against step size"), sections.orders(study)]
    blocks += ["## Closure, phase and drive", sections.closure(study)]
    return [*blocks, "## Whose errors these are", sections.prediction(study)]


def figure(study: SceneStudy, name: str, text: str) -> str:
    """A figure of the scene."""
    return f"![{text}]({FIGURES}/{study.name}-{name}.svg)"


def summary(study: SceneStudy) -> str:
    """The verdict on the scene in a sentence or two."""
    judged = [r for r in study.results if r.passed is not None]
    failed = [r for r in judged if not r.passed]
    if not judged:
        return "Nothing was judged."
    if not failed:
        return f"**All {len(judged)} judged results are within tolerance.**"
    names = ", ".join(" ".join(sections.name_of(r)) for r in failed)
    return f"**{len(failed)} of {len(judged)} judged results did not pass: {names}.**"


def versions(study: SceneStudy) -> str:
    """Engines and their versions."""
    found = dict.fromkeys((r.engine, r.engine_version) for r in study.results)
    return ", ".join(f"{engine_title(engine)} {version}" for engine, version in found)


def _in_words(scene: Scene) -> dict[str, str]:
    facts = scene.parameter_facts()
    return {
        name: " ".join(numbers.in_shown_unit(value, facts[name].unit)).removesuffix(" -")
        for name, value in scene.parameters.items()
    }
