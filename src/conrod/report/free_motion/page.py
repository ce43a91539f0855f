"""The page of a scene's free motion, in Markdown."""

from __future__ import annotations

from conrod.report import numbers
from conrod.report.description import described
from conrod.report.free_motion.folder import figure_file
from conrod.report.free_motion.words import exact_words, loads_words, step_text, verdict_words
from conrod.report.styles import engine_title
from conrod.report.tables import paragraphs, table
from conrod.studies.free_motion.plan import CONTACT_STEPS_A_TURN, LENGTH_ERROR, LONGEST_STEP, STEPS_A_TURN
from conrod.studies.free_motion.results import MotionResult, MotionStudy

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
