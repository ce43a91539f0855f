"""Lines on what moves a model, from the results of its actuators, keyframes and energy."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from conrod.errors import list_names
from conrod.models.inspection.actuator_results import ActuatorResult, largest_step_words, percent_text
from conrod.models.inspection.moving_results import MAX_NAMES, KeyframeHold
from conrod.report.numbers import measured_text, quantity

MAX_EACH = 3  # actuators that are all described one by one
MAX_ALARMS = 6  # lines on what is wrong with actuators


def actuator_lines(results: Sequence[ActuatorResult]) -> Iterator[str]:
    """Yield a line for each actuator; of many, for each faulty one and for each kind of healthy ones."""
    if len(results) <= MAX_EACH:
        yield from (one.words() for one in results)
        return
    alarmed = [one for one in results if one.alarms]
    yield from (f"{one.name} ({one.kind}, {one.drives}): it {'; '.join(one.alarms)}" for one in alarmed[:MAX_ALARMS])
    if more := alarmed[MAX_ALARMS:]:
        yield f"and {len(more)} more: {', '.join(one.name for one in more)}"
    healthy = [one for one in results if not one.alarms]
    for kind in dict.fromkeys(one.kind for one in healthy):
        yield from _kind_lines(kind, [one for one in healthy if one.kind == kind])


def _kind_lines(kind: str, same: list[ActuatorResult]) -> Iterator[str]:
    """Yield a line on a kind's tried actuators, and one for each reason why others were not tried."""
    tried = [one for one in same if one.responses or one.acceleration is not None]
    if tried:
        shown = (
            tried[0].name if len(tried) == 1 else f"{len(tried)} others" if len(tried) < len(same) else f"{len(tried)}"
        )
        yield f"{shown} ({kind}): {', '.join(_common(tried))}"
    left = [one for one in same if one not in tried]
    for reason in dict.fromkeys(one.remark for one in left):
        names = [one.name for one in left if one.remark == reason]
        yield f"{names[0]}{f' and {len(names) - 1} more' if len(names) > 1 else ''} ({kind}): {reason}"


def _common(tried: list[ActuatorResult]) -> Iterator[str]:
    """Yield clauses on the worst error, settling, overshoot and step of healthy actuators of a kind."""
    responses = [response for one in tried for response in one.responses]
    if responses:
        yield f"each reached within {percent_text(max(one.missing_share for one in responses))}"
        yield f"settles within {quantity(max(one.settling or 0.0 for one in responses), 2)} s"
        overshoot = max(one.overshoot for one in responses)
        yield f"overshoots by up to {percent_text(overshoot)}" if overshoot > 1e-3 else "no overshoot"
    elif all(one.acceleration is not None for one in tried):
        sizes = [abs(one.acceleration or 0.0) for one in tried]
        units = " or ".join(dict.fromkeys(f"{one.unit}/s²" for one in tried))
        yield "forces: no position is reached"
        least, most = measured_text(min(sizes)), measured_text(max(sizes))
        yield f"accelerates by {least if least == most else f'{least} to {most}'} {units}"
        if partly := [one.name for one in tried if one.holds is not None and one.holds != one.span]:
            held = f"{len(partly)} hold their load in a part of their range" if len(partly) > 1 else ""
            first = f"{partly[0]} {'the first' if held else 'holds its load in a part of its range'}"
            yield f"{held} only, {first}" if held else f"{first} only"
    steps = [one.steps.largest for one in tried if one.steps is not None and one.steps.largest is not None]
    if steps:
        yield largest_step_words(f"{quantity(1e3 * min(steps), 3)} ms")


def keyframe_lines(held: Sequence[KeyframeHold]) -> Iterator[str]:
    """Yield a line on the keyframes that stay, and one on each that does not."""
    if stay := [one.name for one in held if one.stays]:
        said = "keyframes {} stay" if len(stay) > 1 else "keyframe {} stays"
        yield f"{said.format(list_names(stay, MAX_NAMES))} where its controls hold it"
    yield from (one.words for one in held if not one.stays)
