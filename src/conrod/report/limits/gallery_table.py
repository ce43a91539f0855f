"""The ways in which a run can end, each with runs that end so."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from conrod.report.styles import engine_title
from conrod.report.tables import paragraphs, table
from conrod.studies.limits.grade import LOUD
from conrod.trajectory import Outcome

if TYPE_CHECKING:
    from conrod.studies.limits.gallery import Exhibit

HEAD = ["ended", "that is", "made so by", "machine", "engine", "preset", "steps per revolution", "what told of it"]
NO_SIGN = "-"


def gallery_table(shown: Sequence[Exhibit]) -> str:
    """A row for each run, in the order of the list of outcomes; which outcomes no run shows is said."""
    if not shown:
        return ""
    order = [outcome.slug for outcome in Outcome]
    rows = [_row(one) for one in sorted(shown, key=lambda one: order.index(one.expected))]
    found = {one.outcome for one in shown}
    missing = [f"`{slug}`" for slug in order if slug not in found]
    return paragraphs(table(HEAD, rows), f"No run shows {', '.join(missing)}." if missing else "")


def _row(one: Exhibit) -> list[str]:
    ended = f"`{one.outcome}`" + ("" if one.outcome == one.expected else f", **expected `{one.expected}`**")
    made = f"{one.title}: {one.what}"
    return [
        ended,
        Outcome.of(one.outcome).meaning,
        made,
        one.scene,
        engine_title(one.engine),
        one.preset,
        str(one.steps),
        _signs(one),
    ]


def _signs(one: Exhibit) -> str:
    """What a user would notice without an exact motion; quiet is that there is nothing."""
    signs = [f"the engine warns: {name}" for name in one.warnings]
    if one.finite is False:
        signs.append("numbers that are not finite")
    if one.outcome in LOUD:
        signs.append("there is no trajectory")
    if one.quiet:
        signs.append("**nothing: quiet**")
    if one.solver:
        signs.append(f"its solver: {one.solver}")
    return "; ".join(signs) or NO_SIGN
