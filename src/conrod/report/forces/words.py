"""Standing text of pages on forces.

What results of a validation of forces amount to, in words.
"""

from __future__ import annotations

from collections.abc import Iterable

from conrod.exact.dynamics.sensitivity import INERTIA, MASS
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.runs.trajectory import Outcome
from conrod.studies.forces.results import ForceResult, Stamps
from conrod.studies.forces.seen import Seen

ERRORS = (
    "Forces as the engine tells them, less the exact ones at the crank's angle, rate and angular acceleration at that "
    "instant, over the exact peak of the quantity at constant speed. What has no peak is divided by the largest of its "
    "unit (*of others*). Pins: force on the second body along x and y; slides: along the line's normal, and the moment."
)
CONTACT = (
    "Where the cam's acceleration jumps all forces do: the largest errors are those of a step there. *Between arc "
    "joints* is the rms of what lies more than 1 deg from them, of means of 16 steps, for single values scatter from "
    "an edge of the cam's polygon to the next; it is followed over the step, and of contact judged."
)
STAMPS = "Values belong to these instants, by which they are compared; a wrong one would cost an order."
MASSES = (
    "By the exact sensitivities at constant speed: 1 % of a mass, 1 % of a length, 5 % of an inertia, and the "
    "quantity of those asked for that shows it most. Under an engine stands how many times that change "
    "its own errors look like (their projection on what the change makes): a run that was judged and looks like half "
    "of it or more has not passed. What none of the quantities depends on, no engine's error can tell."
)
NOTHING_BLIND = "No change of several properties together is hidden, but for those that none depends on."
BLIND = "Hidden together, to first order:"


UNITS = {MASS: "kg", INERTIA: "kg m²"}


def verdict(result: ForceResult) -> str:
    """Within tolerance or not, and if not why; what ended the run, where it did not complete."""
    if result.outcome != Outcome.COMPLETED.slug:
        return f"{result.outcome}: {result.reason}"
    untold = "" if not result.unsupported else "; " + " and ".join(untold_words(result))
    if result.passed is None:
        return "measured, not judged" + untold
    if result.passed:
        return "within tolerance" + untold
    parts = [
        f"{group} {numbers.measured(found)} > {numbers.measured(allowed)}"
        for group, (found, allowed) in result.exceeded().items()
    ]
    if parts:
        return "OUT OF TOLERANCE: " + ", ".join(parts) + untold
    return "LOOKS LIKE A WRONG MASS: " + ", ".join(mistaken_words(result)) + untold


def reasons(results: Iterable[ForceResult]) -> list[str]:
    """Why runs are judged by what they are, each reason once with its engine and preset."""
    told = [(r.engine, r.preset, r.reason_of_tolerance) for r in results if r.reason_of_tolerance]
    return [f"{engine_title(engine)} {preset}, {why}" for engine, preset, why in dict.fromkeys(told)]


def mistaken_words(result: ForceResult) -> list[str]:
    """Wrong masses that the errors look like, the most likely one first."""
    found = sorted(result.mistaken().items(), key=lambda pair: -abs(pair[1]))
    return [f"{property_words(name)} by {times:+.2g} changes" for name, times in found]


def untold_words(result: ForceResult) -> list[str]:
    """What the engine does not tell and why, a phrase for each reason."""
    reasons: dict[str, list[str]] = {}
    for name, reason in (result.unsupported or {}).items():
        joint = name.rpartition(".")[0] or name
        names = reasons.setdefault(reason, [])
        if joint not in names:
            names.append(joint)
    return [f"unsupported: {', '.join(names)} ({reason})" for reason, names in reasons.items()]


def stamps_words(stamps: Stamps | None) -> str:
    """Which instants the values belong to."""
    if stamps is None:
        return numbers.MISSING
    spaced = "every step" if stamps.spacing == 1.0 else f"every {stamps.spacing:g} steps, each a mean of these"
    left_out = f"; {stamps.left_out} left out at change points" if stamps.left_out else ""
    return f"{stamps.count} values, {spaced}, the first at {stamps.first:g} steps after the start{left_out}"


def unseen_words(seen: Seen) -> list[str]:
    """Properties that no quantity depends on."""
    return [f"{effect.body} {property_words(effect.quality)}" for effect in seen.effects if effect.unseen]


def blind_words(seen: Seen) -> list[str]:
    """Changes of several properties together that no quantity sees."""
    return [
        " with ".join(f"{body} {property_words(name)} {_signed(v, name)}" for (body, name), v in blind.shares.items())
        for blind in seen.blind
    ]


def property_words(quality: str) -> str:
    """A body's property as people say it."""
    return quality.replace("_", " ").replace(".", " ")


def change_words(quality: str, change: float) -> str:
    """How much of a property, with its unit."""
    unit = UNITS.get(quality)
    return f"{numbers.quantity(change)} {unit}" if unit else f"{numbers.quantity(1e3 * change)} mm"


def _signed(value: float, quality: str) -> str:
    return ("+" if value >= 0.0 else "-") + change_words(quality, abs(value))
