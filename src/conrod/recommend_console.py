"""What `conrod recommend` prints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from conrod.console import console
from conrod.studies.recommendation import Confirmation, Recommendation, Refusal, Rejected


def print_recommendations(found: Sequence[Recommendation | Refusal], allowed: Mapping[str, float]) -> None:
    """A block for each engine."""
    out = console()
    for answer in found:
        lines = _recommended(answer, allowed) if isinstance(answer, Recommendation) else _refused(answer, allowed)
        out.print("\n".join(lines) + "\n", markup=False, soft_wrap=True)


def _recommended(found: Recommendation, allowed: Mapping[str, float]) -> list[str]:
    preset = f" (the preset {found.preset!r})" if found.preset else ""
    errors = ", ".join(f"{q} {e:.1e} (allowed {allowed[q]:g})" for q, e in found.errors.items())
    timing = found.timing
    return [
        f"{found.engine}: {found.rule}, {found.cell.settings.steps_per_revolution} steps per revolution{preset}",
        f"  largest errors: {errors}; margin {found.margin:.2g}",
        f"  cost: {1e3 * timing.seconds_per_revolution:.3g} ms of CPU time a revolution on this machine, "
        f"as much as {timing.ratio:.3g} steps of the engine's reference loop",
        f"  confirmed: {'; '.join(_confirmed(c) for c in found.confirmations)}",
        *_rejected(found.rejected),
        *_stock(found, allowed),
        f"  carries by: {found.groups.in_words()}",
        "  to paste:",
        *(f"    {line}" for line in found.paste.splitlines()),
    ]


def _confirmed(confirmation: Confirmation) -> str:
    errors = ", ".join(f"{q} {e:.1e}" for q, e in (confirmation.errors or {}).items())
    return f"{confirmation.what} {errors}"


def _rejected(rejected: Sequence[Rejected]) -> list[str]:
    return [
        f"  cheaper, but not confirmed: {r.rule}, {r.steps_per_revolution} steps per revolution ({r.why})"
        for r in rejected
    ]


def _stock(found: Recommendation, allowed: Mapping[str, float]) -> list[str]:
    stock, words = found.stock, list[str]()
    if found.preset == "stock":
        return ["  these are the stock settings"]
    for quantity, digits in stock.digits.items():
        if digits is None:
            words.append(f"no stock run is as cheap ({quantity})")
        else:
            words.append(f"{digits:+.1f} digits of {quantity} at equal cost")
    if stock.cost_factor is not None:
        words.append(f"stock settings cost {stock.cost_factor:.3g} times as much for the same tolerance")
    else:
        best = ", ".join(f"{q} {e:.1e}" for q, e in stock.best.items() if e > allowed[q])
        words.append("stock settings never get there" + (f" (at best {best})" if best else ""))
    return [f"  against stock: {'; '.join(words)}"]


def _refused(found: Refusal, allowed: Mapping[str, float]) -> list[str]:
    if found.why:
        return [f"{found.engine}: nothing qualifies: {found.why}"]
    over = ", ".join(f"{q} is {x:.3g} times what is allowed" for q, x in found.excess.items())
    errors = ", ".join(f"{q} {e:.1e} (allowed {allowed[q]:g})" for q, e in found.errors.items())
    why = over or "what the grid allows was not confirmed"
    return [
        f"{found.engine}: nothing qualifies: {why}",
        f"  nearest: {found.rule}, {found.steps_per_revolution} steps per revolution: {errors}",
        *_rejected(found.rejected),
    ]
