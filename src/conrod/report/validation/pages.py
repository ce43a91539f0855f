"""A scene's page in Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.report import numbers
from conrod.report.charts.styles import FIGURE_NAMES, completed, engine_title
from conrod.report.tables import bullets, paragraphs
from conrod.report.validation import prose, sections
from conrod.report.validation.prose import described
from conrod.report.validation.settings_table import settings
from conrod.scenes import Scene
from conrod.studies.validation.results import Result, SceneStudy

FIGURES = "figures"


def scene_page(study: SceneStudy, command: str, shown: Sequence[str] = FIGURE_NAMES) -> str:
    """The page of one scene.

    Args:
        command: what reproduces the page.
        shown: names of the figures that it shows.
    """
    scene = study.scene
    blocks = [
        f"# {study.name}: {scene.title}",
        described(scene),
        assumed(scene),
        f"Source: {scene.source}.",
        "" if scene.closed_form else prose.GENERIC_RULER,
        f"Reproduced by `{command}`, with {versions(study)}. See the [index](README.md) for the other machines.",
        "## Verdict",
        summary(study),
        sections.verdicts(study),
        prose.PRESETS,
        "## Mechanism",
        figure(study, "mechanism", f"The mechanism of {study.name} with its dimensions", shown),
        f"Frame: {scene.frame}",
        sections.parameters(study),
        prose.MASSES if scene.closed_form else prose.MASSES_OF_A_FILE,
        "## Proof of the model: kinematic mode",
        sections.kinematic(study),
        *_measured(study, shown),
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


def _measured(study: SceneStudy, shown: Sequence[str]) -> list[str]:
    """The sections that need at least one run that completed."""
    runs = completed(study.results)
    if not runs:
        return ["## Errors", "No run completed, so there are no errors to show."]
    whole, last = _stretch(study, runs[0])
    curves = figure(study, "motion", "Position, velocity and acceleration of the engines over the exact curve", shown)
    blocks = ["## Motion", f"Over {last}.", curves] if curves else []
    errors = figure(study, "error", "Error of every run against the crank angle", shown)
    legend = (
        f"The largest error over the observed points, over {whole}; arrow heads at the right edge "
        "are tolerances of the run of the same colour and fill."
    )
    blocks += ["## Errors", errors, legend if errors else "", sections.errors(study)]
    if any(run.refinement for run in runs):
        along = figure(study, "order", "Error against step size", shown)
        blocks += ["## Order of convergence", along, sections.orders(study)]
    blocks += ["## Closure, phase and drive", sections.closure(study)]
    return [*blocks, "## Whose errors these are", sections.prediction(study)]


def _stretch(study: SceneStudy, run: Result) -> tuple[str, str]:
    """What was run, and of that what the curves show."""
    if study.scene.kinematics.mechanism.driver.span is None:
        revolutions = numbers.quantity(run.revolutions)
        return f"{revolutions} revolutions", f"the last of {revolutions} revolutions"
    degrees = numbers.quantity(360.0 * run.revolutions)
    return f"the pass of {degrees} deg", f"the pass of {degrees} deg that the input makes, which cannot turn fully"


def figure(study: SceneStudy, name: str, text: str, shown: Sequence[str] = FIGURE_NAMES) -> str:
    """A figure of the scene; nothing where the page does not show it."""
    return f"![{text}]({FIGURES}/{study.name}-{name}.svg)" if name in shown else ""


def assumed(scene: Scene) -> str:
    """What the scene assumes, a point each; nothing where it assumes nothing."""
    return paragraphs("Assumed:", bullets(scene.assumptions)) if scene.assumptions else ""


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
