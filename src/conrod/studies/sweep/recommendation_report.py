"""Recommendations in lines for a terminal, and as a report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from conrod.engines.engine import CUSTOM
from conrod.execution.tolerances import judged_scale, scene_scales
from conrod.report import numbers
from conrod.report.kind import Kind
from conrod.report.results import distrust_lines, distrust_words
from conrod.report.table import Verbatim
from conrod.report.terminal import PrintedPart
from conrod.scenes import Scene
from conrod.studies.sweep.recommend import Answer, Confirmation, NoRecommendation, Recommendation, RejectedCandidate
from conrod.studies.sweep.step_search import Candidate, Tolerances


@dataclass(frozen=True)
class Advice:
    """Settings recommended for one scene, as plain values.

    Attributes:
        engines: versions by name.
        answers: answers by engine, with the lines that a terminal shows.
        distrust: scenes and engines whose figures cannot be trusted, and why, in words; empty if all can.
    """

    name: str
    title: str
    parameters: Mapping[str, Any]
    allowed: Tolerances
    engines: Mapping[str, str]
    answers: Mapping[str, Any]
    distrust: str = ""


def advice_of(name: str, scene: Scene, allowed: Tolerances, found: Sequence[Answer]) -> Advice:
    """Collect the answers of all engines for a scene as plain values."""
    engines = [(one.candidate if isinstance(one, Recommendation) else one.nearest).rule_plan.engine for one in found]
    answers = {engine.name: _answer_values(one, allowed) for engine, one in zip(engines, found, strict=True)}
    versions = {engine.name: engine.version for engine in engines}
    distrust = "; ".join(one.distrust for one in found if one.distrust)
    return Advice(name, scene.title, dict(scene.parameters), allowed, versions, answers, distrust)


def _answer_values(found: Answer, allowed: Tolerances) -> dict[str, Any]:
    """Convert the answer of an engine to plain values: its setting, or the nearest one, and rejected ones."""

    def choice_values(choice: Candidate) -> dict[str, Any]:
        """Rule, steps per revolution and errors of a candidate."""
        return {"rule": choice.rule_plan.rule.name, "steps": choice.steps, "errors": choice.errors(allowed)}

    values: dict[str, Any] = {"qualifies": isinstance(found, Recommendation)}
    if isinstance(found, Recommendation):
        values |= choice_values(found.candidate) | {
            "margin": found.margin,
            "settings": found.rounded_settings.as_dict(),
            "timing": asdict(found.timing),
            "confirmations": {one.change: one.errors(allowed) for one in found.confirmations},
            "paste": found.paste,
        }
    else:
        values |= {"why": found.reason, "nearest": choice_values(found.nearest)}
    return values | {
        "rejected": [
            {
                **choice_values(one.candidate),
                "why": {c.change: c.errors(allowed) or c.result.outcome for c in one.failed_confirmations},
            }
            for one in found.rejected
        ],
        "how": found.search_words,
        "lines": list(
            _recommendation_lines(found, allowed)
            if isinstance(found, Recommendation)
            else _refusal_lines(found, allowed)
        ),
    }


def results_to_print(studies: Sequence[Advice]) -> Iterator[PrintedPart]:
    """Yield the answer of each engine, and the settings to paste."""
    yield from distrust_lines(studies)
    for one in (answer for study in studies for answer in study.answers.values()):
        yield from one["lines"]
        yield from (Verbatim(f"    {line}") for line in [*one.get("paste", "").splitlines(), ""])


def verdict(found: Advice) -> str:
    """Return the first line of each engine's answer, or say that its figures cannot be trusted."""
    return distrust_words(found) or "; ".join(one["lines"][0].rstrip(":") for one in found.answers.values())


RECOMMENDATION_REPORT = Kind(
    name="recommendation",
    findings=Advice,
    title=lambda found: found.title,
    summary=lambda found: {name: one["qualifies"] for name, one in found.answers.items()},
    printed=results_to_print,
    verdict=verdict,
    passed=lambda found: any(one["qualifies"] for one in found.answers.values()),
    one_part=True,
)


def _recommendation_lines(found: Recommendation, allowed: Tolerances) -> Iterator[str]:
    choice, timing, settings = found.candidate, found.timing, found.candidate.case.settings
    preset = "" if settings.preset == CUSTOM else f" (the preset {settings.preset!r})"
    yield f"{choice.rule_plan.engine.name}: {_setting_text(choice)}{preset}"
    yield f"  largest errors: {_errors_with_limits(choice, allowed)}; margin {found.margin:.2g}"
    yield (
        f"  cost: {1e3 * timing.seconds_per_revolution:.3g} ms of CPU time a revolution on this machine, as much as "
        f"{float(f'{timing.ratio:.3g}'):g} steps of the engine's reference loop"
    )
    confirmed = [
        f"{one.change} {_error_list(_error_texts(one, allowed, choice.case.scene))}" for one in found.confirmations
    ]
    yield f"  confirmed: {'; '.join(confirmed)}"
    yield from _rejected_lines(found.rejected, allowed)
    yield f"  found {found.search_words}"
    yield "  to paste:"


def _refusal_lines(found: NoRecommendation, allowed: Tolerances) -> Iterator[str]:
    if found.reason:
        yield f"{found.engine}: nothing qualifies: {found.reason}"
        return
    excess = {q: error / allowed[q] for q, error in found.nearest.errors(allowed).items() if error > allowed[q]}
    over = ", ".join(f"{q} is {x:.3g} times what is allowed" for q, x in excess.items())
    yield f"{found.engine}: nothing qualifies: {over or 'what was within tolerance was not confirmed elsewhere'}"
    yield f"  nearest: {_setting_text(found.nearest)}: {_errors_with_limits(found.nearest, allowed)}"
    yield from _rejected_lines(found.rejected, allowed)
    yield f"  sought {found.search_words}"


def _setting_text(choice: Candidate) -> str:
    return f"{choice.rule_plan.rule.name}, {choice.steps} steps per revolution"


def _error_texts(found: Candidate | Confirmation, allowed: Tolerances, scene: Scene) -> dict[str, str]:
    places = {point: sizes["position"]["max"] for point, sizes in (found.result.errors or {}).items()}
    errors = found.errors(allowed)
    return {q: numbers.error(q, places if q == "position" else e, scene.lengths) for q, e in errors.items()}


def _error_list(errors: Mapping[str, str]) -> str:
    return ", ".join(f"{q} {size}" for q, size in errors.items())


def _errors_with_limits(choice: Candidate, allowed: Tolerances) -> str:
    errors = _error_texts(choice, allowed, choice.case.scene)
    return _error_list({q: f"{size} of {_limit_text(q, allowed[q], choice)} allowed" for q, size in errors.items()})


def _limit_text(quantity: str, allowed: float, choice: Candidate) -> str:
    """Return a tolerance as a share, with its size for the point that is most in error."""
    scales = scene_scales(choice.case.scene)[quantity]
    scale = judged_scale(choice.point_errors(quantity), scales, weighed=quantity in choice.weights)
    return numbers.with_size(numbers.quantity(allowed), quantity, allowed, scale)


def _rejected_lines(rejected: tuple[RejectedCandidate, ...], allowed: Tolerances) -> Iterator[str]:
    for one in rejected:
        shown = ((c, _error_list(_error_texts(c, allowed, one.candidate.case.scene))) for c in one.failed_confirmations)
        lost = "; ".join(f"{c.change}: {errors or c.result.outcome}" for c, errors in shown)
        yield f"  cheaper, but not confirmed: {_setting_text(one.candidate)} ({lost})"
