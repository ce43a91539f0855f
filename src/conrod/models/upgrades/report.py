"""The report on a model in several releases of MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from conrod.models.upgrades.results import COMPILED, REFUSED, ROUNDING, TERM, ModelChange, UpgradeStudy
from conrod.report import numbers
from conrod.report.kind import Kind
from conrod.report.table import VERDICT, Cell, ColouredCell, Table, Tone, table
from conrod.report.terminal import PrintedPart

COST_TONES: Mapping[str, Tone] = {"slower": "odd", "faster": "good"}
KIND_WORDS = {
    REFUSED: "it is refused", COMPILED: "another compiled model", TERM: "a term changed", ROUNDING: "rounding",
}  # fmt: skip


def motion_words(change: ModelChange) -> str:
    """Say how far the model is from where it was: its end, a distance, or last digits only."""
    if change.ended[0] != change.ended[1]:
        return f"{change.ended[0]}, now {change.ended[1]}"
    if change.moved is None or change.share is None:
        return "other bodies"
    if change.last_digits:
        return "last digits"
    return f"{numbers.measured_text(1e3 * change.moved)} mm ({change.body}, at {change.at:.3g} s)"


def change_sentence(change: ModelChange) -> str:
    """Describe how a release changed the model's run, and the cause."""
    if change.kind == REFUSED:
        return f"{change.version} does not load it: {change.cause}"
    parted = f" They part at {change.parted_at:.3g} s." if change.parted_at is not None else ""
    moved = motion_words(change)
    what = f"the run {moved}" if change.ended[0] != change.ended[1] else f"the motion changes by {moved}"
    return f"{change.version}: {what}. {change.cause[:1].upper()}{change.cause[1:]}.{parted}"


def headline(study: UpgradeStudy) -> str:
    """Say which release changed the model most, and why; or that none did."""
    span = f"{study.measured[0]} to {study.measured[-1]}" if len(study.measured) > 1 else study.measured[0]
    if len(study.measured) < 2 and not study.changes:
        return f"{study.file} ran in {span} alone: name two releases."
    if not study.changes:
        return f"{study.file}: the same to the last bit in {span}, over {study.seconds:g} s from {study.start}."
    if refused := [change for change in study.changes if change.kind == REFUSED]:
        return f"{study.file}: {change_sentence(refused[0])}."
    real = [change for change in study.changes if change.kind != ROUNDING]
    if not real:
        worst = max(study.changes, key=lambda one: one.share or 0.0)
        return f"{study.file}: no release of {span} changed a term of it. {change_sentence(worst)}"
    worst = max(real, key=lambda one: (one.ended[0] != one.ended[1], one.share or 0.0))
    more = f" {len(real) - 1} more below." if len(real) > 1 else ""
    return f"{study.file}: {change_sentence(worst)}{more}"


def changes_table(study: UpgradeStudy) -> Table:
    """Return a row for each release that changed the run, with the cause and the changelog's entries."""
    rows: list[tuple[Cell, ...]] = []
    for change in study.changes:
        tone: Tone = "good" if change.kind == ROUNDING else "bad" if change.kind == REFUSED else "odd"
        parted = "" if change.parted_at is None else f"{change.parted_at:.3g} s"
        entries = " ".join(change.explained) or "nothing that conrod knows of"
        kind = ColouredCell(KIND_WORDS[change.kind], tone)
        rows.append((change.version, motion_words(change), parted, kind, entries))
    title = f"{study.file}: what changed from the release before, over {study.seconds:g} s from {study.start}"
    headings = ("release", "motion changed by", "parts at", "why", "its changelog")
    return table(headings, rows, title=title, names=1)


def other_sentences(study: UpgradeStudy) -> list[str]:
    """Describe each change that the headline leaves out."""
    said = headline(study)
    return [words for change in study.changes if (words := change_sentence(change)) not in said]


def costs_table(study: UpgradeStudy) -> Table:
    """Return a row for each other release: the CPU time of a step over that in the reference, with the interval."""
    rows: list[tuple[Cell, ...]] = []
    for one in study.costs:
        if one.timing is None or one.noise is None:
            rows.append((one.version, numbers.MISSING, "", f"not timed: {one.reason}"))
            continue
        ratio = f"{one.timing.ratio:.2f} ({one.timing.low:.2f} to {one.timing.high:.2f})"
        noise = f"{one.noise.low:.2f} to {one.noise.high:.2f}"
        tone = COST_TONES.get(one.word)
        rows.append((one.version, ratio, noise, ColouredCell(one.word, tone) if tone else one.word))
    title = f"{study.file}: CPU time of a step over that with {study.reference}"
    return table(("release", "ratio", f"{study.reference} twice", VERDICT), rows, title=title, names=1)


def unsupported_lines(study: UpgradeStudy) -> list[str]:
    """List releases that did not run the model, with the reason, unless the table of changes does."""
    said = {change.version for change in study.changes if change.kind == REFUSED}
    return [f"mujoco {version} unsupported: {why}" for version, why in study.unsupported.items() if version not in said]


def results_to_print(studies: Sequence[UpgradeStudy]) -> Iterator[PrintedPart]:
    """Yield for each model a sentence, the table of changes, the costs, and the releases that were not run."""
    for study in studies:
        yield headline(study)
        if study.changes:
            yield changes_table(study)
            yield from other_sentences(study)
        if study.costs:
            yield costs_table(study)
        yield from unsupported_lines(study)


def _summary(study: UpgradeStudy) -> dict[str, Any]:
    return {"headline": headline(study), "releases": list(study.measured)}


def _joined_headlines(entries: Mapping[str, Mapping[str, Any]]) -> str:
    return " ".join(entry["summary"]["headline"] for entry in entries.values())


UPGRADES_REPORT = Kind(
    name="upgrades",
    findings=UpgradeStudy,
    title=lambda study: study.file,
    summary=_summary,
    printed=results_to_print,
    verdict=headline,
    headline=_joined_headlines,
    digits=4,
)
