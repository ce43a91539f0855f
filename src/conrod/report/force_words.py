"""Results of a validation of forces in words, the same on the console and on a page."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from conrod.exact.dynamics.sensitivity import INERTIA, MASS
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.runs.trajectory import Outcome
from conrod.studies.forces.results import ForceResult, Stamps
from conrod.studies.forces.seen import Effect

UNITS = {MASS: "kg", INERTIA: "kg m²"}


def verdict_words(result: ForceResult) -> str:
    """Within tolerance or not, and if not why; what ended the run, where it did not complete."""
    if result.outcome != Outcome.COMPLETED.slug:
        return f"{result.outcome}: {result.reason}"
    lacking = "; " + " and ".join(unsupported_words(result)) if result.unsupported else ""
    if result.passed is not False:
        return ("measured, not judged" if result.passed is None else "within tolerance") + lacking
    parts = [
        f"{group} {numbers.measured(found)} > {numbers.measured(allowed)}"
        for group, (found, allowed) in result.exceeded().items()
    ]
    if parts:
        return "OUT OF TOLERANCE: " + ", ".join(parts) + lacking
    return "LOOKS LIKE A WRONG MASS: " + ", ".join(mistaken_words(result)) + lacking


def tolerance_reasons(results: Iterable[ForceResult]) -> list[str]:
    """The reasons of the tolerances, each once with its engine and preset."""
    given = [(r.engine, r.preset, r.reason_of_tolerance) for r in results if r.reason_of_tolerance]
    return [f"{engine_title(engine)} {preset}, {why}" for engine, preset, why in dict.fromkeys(given)]


def mistaken_words(result: ForceResult) -> list[str]:
    """Wrong masses that the errors look like, the most likely one first."""
    found = sorted(result.mistaken().items(), key=lambda pair: -abs(pair[1]))
    return [f"{property_words(name)} by {times:+.2g} changes" for name, times in found]


def unsupported_words(result: ForceResult) -> list[str]:
    """Quantities that the engine does not report, a phrase for each reason."""
    reasons: dict[str, list[str]] = {}
    for name, reason in (result.unsupported or {}).items():
        joint = name.rpartition(".")[0] or name
        names = reasons.setdefault(reason, [])
        if joint not in names:
            names.append(joint)
    return [f"unsupported: {', '.join(names)} ({reason})" for reason, names in reasons.items()]


def stamps_words(stamps: Stamps | None) -> str:
    """The instants that the values belong to."""
    if stamps is None:
        return numbers.MISSING
    spaced = "every step" if stamps.spacing == 1.0 else f"every {stamps.spacing:g} steps, each a mean of these"
    left_out = f"; {stamps.left_out} left out at change points" if stamps.left_out else ""
    return f"{stamps.count} values, {spaced}, the first at {stamps.first:g} steps after the start{left_out}"


def unseen_words(effects: Iterable[Effect]) -> list[str]:
    """Properties that no quantity depends on."""
    return [f"{effect.body} {property_words(effect.quality)}" for effect in effects if effect.unseen]


def hidden_words(hidden: Iterable[Mapping[str, float]]) -> list[str]:
    """Changes of several properties together, by "body.property", that no quantity shows."""
    return [" with ".join(_changed(name, change) for name, change in shares.items()) for shares in hidden]


def _changed(name: str, change: float) -> str:
    body, _, quality = name.partition(".")
    sign = "+" if change >= 0.0 else "-"
    return f"{body} {property_words(quality)} {sign}{change_words(quality, abs(change))}"


def property_words(quality: str) -> str:
    """A body's property as people say it."""
    return quality.replace("_", " ").replace(".", " ")


def change_words(quality: str, change: float) -> str:
    """A change of a property with its unit."""
    unit = UNITS.get(quality)
    return f"{numbers.quantity(change)} {unit}" if unit else f"{numbers.quantity(1e3 * change)} mm"
