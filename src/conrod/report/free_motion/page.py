"""Files of free motion in a report's folder, which may hold other reports' pages too.

The page of a scene's free motion, in Markdown.

All files of scenes' free motion, rendered before any is written.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from conrod.report import numbers
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.charts.styles import engine_title
from conrod.report.folder import check_beside, check_own_folder, holds_document
from conrod.report.free_motion.document import page_document
from conrod.report.free_motion.figure import motion_figure
from conrod.report.free_motion.words import exact_words, loads_words, step_text, verdict_words
from conrod.report.reproduction import Reproduction
from conrod.report.tables import paragraphs, table
from conrod.report.validation.prose import described
from conrod.studies.frame.files import Batch
from conrod.studies.free_motion.plan import CONTACT_STEPS_A_TURN, LENGTH_ERROR, LONGEST_STEP, STEPS_A_TURN
from conrod.studies.free_motion.results import MotionResult, MotionStudy

FIGURES = "figures"
# Of the numbers of a page, by which it is known.
KEYS = {"schema", "motion", "scene", "exact"}


def page_file(scene: str) -> str:
    """A scene's page."""
    return f"{scene}-motion.md"


def numbers_file(scene: str) -> str:
    """Its numbers for machines."""
    return f"{scene}-motion.json"


def figure_file(scene: str) -> str:
    """Its figure; another one than that of a driven crank's motion."""
    return f"{FIGURES}/{scene}-free-motion.svg"


def check_motion_folder(directory: Path, scenes: Iterable[str]) -> None:
    """Refuse a folder in which a page of free motion would replace what is none.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    for scene in scenes:
        own = holds_document(directory / numbers_file(scene), KEYS)
        pages = (page_file(scene), numbers_file(scene))
        check_own_folder(directory, pages, (figure_file(scene),), FIGURES, own, "a page of free motion")


def check_motion_apart(document: Path, directory: Path, scenes: Iterable[str]) -> None:
    """Refuse a file that is one of those that the pages of some scenes consist of.

    Raises:
        InvalidInput: names the file.
    """
    names = [make(scene) for scene in scenes for make in (page_file, numbers_file, figure_file)]
    check_beside(document, directory, names)


READING = (
    "Nothing prescribes the crank: what is compared is the trajectory itself, at the same time. Position errors are "
    "distances from the exact place of an observed point, divided by L, the largest distance between two of its exact "
    "positions in a turn of the crank; of several points the worst counts. The error of energy is that of kinetic and "
    "potential energy together, against the exact one at the same time, divided by the largest kinetic energy or "
    "change of the potential one. Where no load takes energy this is the engine's drift."
)
RULE = (
    f"Where no step is asked for it is {1e3 * LONGEST_STEP:g} ms, halved until the fastest turn, which is 2 pi times "
    "the largest velocity of an observed point over its largest acceleration, has "
    f"{STEPS_A_TURN} steps, or {CONTACT_STEPS_A_TURN} with contact."
)
HEAD = ("engine", "preset", "step", "position max", "rms", "final", "crank angle [rad]", "energy")
ORDER = "An order is told where the errors of the three runs fall alike from one to the next."


def motion_page(study: MotionStudy, command: str) -> str:
    """The page.

    Args:
        command: what makes it again.
    """
    versions = ", ".join(
        f"{engine_title(engine)} {version}"
        for engine, version in dict.fromkeys((r.engine, r.engine_version) for r in study.results)
    )
    leaving = study.results[0].leaving if study.results else LENGTH_ERROR
    blocks = [
        f"# {study.name}: {study.scene.title}, {'let go' if study.motion == 'free' else 'driven by its torques'}",
        described(study.scene),
        f"{_begun(loads_words(study))} {numbers.quantity(float(study.exact.times[-1]))} s from the start in motion.",
        exact_words(study),
        f"Reproduced by `{command}`, with {versions}.",
        "## Verdict",
        _summary(study),
        table(("engine", "preset", "verdict"), [(*_name(r), verdict_words(r)) for r in study.results]),
        "## Motion",
        f"![Crank angle, error and drift of energy over time]({figure_file(study.name)})"
        if any(r.curves is not None for r in study.results)
        else "No run completed, so there is no motion to show.",
        READING,
        "## Errors",
        table(
            (*HEAD, f"above {numbers.quantity(leaving)} from"),
            [_errors(r) for r in study.results],
        ),
        "## Steps",
        RULE,
        table(("engine", "preset", "step", "outcome", "position", "energy"), _steps(study)),
        table(
            ("engine", "preset", "order of position", "order of energy"),
            [_order(r) for r in study.results if r.order],
        ),
        ORDER,
    ]  # fmt: skip
    return paragraphs(*blocks) + "\n"


def _summary(study: MotionStudy) -> str:
    judged = [r for r in study.results if r.passed is not None]
    if not judged:
        return "Nothing was judged."
    failed = [r for r in judged if not r.passed]
    if not failed:
        count = "The judged result is" if len(judged) == 1 else f"All {len(judged)} judged results are"
        return f"**{count} within tolerance.**"
    names = ", ".join(" ".join(_name(r)) for r in failed)
    return f"**{len(failed)} of {len(judged)} judged results did not pass: {names}.**"


def _name(result: MotionResult) -> tuple[str, str]:
    return engine_title(result.engine), result.preset


def _errors(result: MotionResult) -> tuple[str, ...]:
    sizes = (numbers.measured(result.largest("position", measure)) for measure in ("max", "rms", "final"))
    others = (numbers.measured(result.largest(name)) for name in ("angle", "energy"))
    leaves = (
        numbers.MISSING if result.errors is None else "never" if result.leaves is None else f"{result.leaves:.4g} s"
    )
    return (*_name(result), step_text(result.step), *sizes, *others, leaves)


def _steps(study: MotionStudy) -> list[tuple[str, ...]]:
    return [
        (*_name(r), step_text(p.step), p.outcome, numbers.measured(p.position), numbers.measured(p.energy))
        for r in study.results
        for p in r.refinement
    ]


def _order(result: MotionResult) -> tuple[str, ...]:
    orders = result.order or {}
    return (*_name(result), *(numbers.order(orders[name]) for name in ("position", "energy")))


def _begun(text: str) -> str:
    """With a capital; `capitalize` would make the others small."""
    return text[0].upper() + text[1:]


def motion_batch(studies: Sequence[MotionStudy], folder: Path, command: Reproduction) -> Batch:
    """A figure, the numbers and the page of each scene; a figure that only an earlier page had goes."""
    files: dict[str, str | bytes] = {}
    stale = []
    for study in studies:
        alone = command.of(study.name)
        if any(result.curves is not None for result in study.results):
            with drawing_style():
                files[figure_file(study.name)] = svg_text(motion_figure(study))
        elif (folder / figure_file(study.name)).is_file():
            stale.append(figure_file(study.name))
        files[numbers_file(study.name)] = page_document(study, alone)
        files[page_file(study.name)] = motion_page(study, alone)
    return Batch(folder, files, tuple(stale))
