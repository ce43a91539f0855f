"""Recommendations in lines for a terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from conrod.engines.engine import STOCK
from conrod.studies.recommend.recommendation import Confirmation, Groups, Recommendation, Refusal, Rejected


def answer_lines(found: Recommendation | Refusal, allowed: Mapping[str, float]) -> list[str]:
    """Lines on the answer for one engine.

    Args:
        allowed: largest error by quantity.
    """
    return _recommended(found, allowed) if isinstance(found, Recommendation) else _refused(found, allowed)


def _recommended(found: Recommendation, allowed: Mapping[str, float]) -> list[str]:
    preset = f" (the preset {found.preset!r})" if found.preset else ""
    timing = found.timing
    return [
        f"{found.engine}: {found.rule}, {found.case.settings.steps_per_revolution} steps per revolution{preset}",
        f"  largest errors: {_errors_allowed(found.errors, allowed)}; margin {found.margin:.2g}",
        f"  cost: {1e3 * timing.seconds_per_revolution:.3g} ms of CPU time a revolution on this machine, "
        f"as much as {timing.ratio:.3g} steps of the engine's reference loop",
        f"  confirmed: {'; '.join(f'{c.what} {_errors(c.errors or {})}' for c in found.confirmations)}",
        *_rejected(found.rejected),
        *_savings(found, allowed),
        f"  depends on: {_groups(found.groups)}",
        "  to paste:",
        *(f"    {line}" for line in found.paste.splitlines()),
    ]


def _refused(found: Refusal, allowed: Mapping[str, float]) -> list[str]:
    if found.why:
        return [f"{found.engine}: nothing qualifies: {found.why}"]
    over = ", ".join(f"{q} is {x:.3g} times what is allowed" for q, x in found.excess.items())
    nearest = f"{found.rule}, {found.steps_per_revolution} steps per revolution"
    return [
        f"{found.engine}: nothing qualifies: {over or 'what the grid allows was not confirmed'}",
        f"  nearest: {nearest}: {_errors_allowed(found.errors, allowed)}",
        *_rejected(found.rejected),
    ]


def _errors(errors: Mapping[str, float]) -> str:
    return ", ".join(f"{q} {e:.1e}" for q, e in errors.items())


def _errors_allowed(errors: Mapping[str, float], allowed: Mapping[str, float]) -> str:
    return ", ".join(f"{q} {e:.1e} (allowed {allowed[q]:g})" for q, e in errors.items())


def _rejected(rejected: Sequence[Rejected]) -> list[str]:
    return [
        f"  cheaper, but not confirmed: {r.rule}, {r.steps_per_revolution} steps per revolution "
        f"({'; '.join(_lost(one) for one in r.why)})"
        for r in rejected
    ]


def _lost(confirmation: Confirmation) -> str:
    return f"{confirmation.what}: {_errors(confirmation.errors) if confirmation.errors else confirmation.outcome}"


def _savings(found: Recommendation, allowed: Mapping[str, float]) -> list[str]:
    savings, words = found.savings, list[str]()
    if found.preset == STOCK:
        return ["  these are the stock settings"]
    for quantity, digits in savings.digits.items():
        none = f"no stock run is as cheap ({quantity})"
        words.append(none if digits is None else f"{digits:+.1f} digits of {quantity} at equal cost")
    if savings.cost_factor is not None:
        words.append(f"stock settings cost {savings.cost_factor:.3g} times as much for the same tolerance")
    else:
        best = _errors({q: e for q, e in savings.best.items() if e > allowed[q]})
        words.append("stock settings never get there" + (f" (at best {best})" if best else ""))
    return [f"  against stock: {'; '.join(words)}"]


def _groups(groups: Groups) -> str:
    words = [
        f"{groups.steps_per_revolution} steps per revolution",
        f"omega x time constant = {groups.time_constant:.3g}",
        f"mass ratio = {groups.mass_ratio:.3g}",
    ]
    if groups.transmission_angle is not None:
        words.append(f"least transmission angle = {math.degrees(groups.transmission_angle):.1f} deg")
    return ", ".join(words)
