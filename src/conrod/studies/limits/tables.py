"""Tables of a report on limits, and the words on walks and runs in them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.table import VERDICT, ColouredCell, Table, table
from conrod.report.template import join_words
from conrod.studies.limits.determinism import Determinism
from conrod.studies.limits.follower_float import ONSET_TOLERANCE, FollowerFloat
from conrod.studies.limits.records import LEVELS, ROUGH_ERROR, SAFE_ERROR
from conrod.studies.limits.results import Probe, Walk

WHO = ("engine", "preset")
# Headings of columns by criterion.
BOUNDARIES = {"safe": f"within {100 * SAFE_ERROR:g} %", "rough": f"within {100 * ROUGH_ERROR:g} %"}
BEYOND_ROUGH = f"beyond {100 * ROUGH_ERROR:g} %"
EVERYWHERE, NOWHERE, NONE = "all of it", "none of it", "-"
LARGEST_ERROR = "largest position error / L"


# -- words -----------------------------------------------------------------------------------------------------------


def engine_and_preset(finding: Any) -> tuple[str, str]:
    """Return engine and preset, the first cells of a row."""
    return engine_title(finding.engine), finding.preset


def boundary_text(walk: Walk, criterion: str) -> str:
    """Return the last value that keeps a criterion; on a list of values, how many do."""
    if not walk.boundaries:
        good = LEVELS[: LEVELS.index(criterion) + 1]
        return f"{sum(probe.level in good for probe in walk.probes)} of {len(walk.probes)}"
    boundary = next(one for one in walk.boundaries if one.criterion == criterion)
    if boundary.first_bad is None:
        return EVERYWHERE
    return next((probe.text for probe in walk.probes if probe.value == boundary.last_good), NOWHERE)


def ending_words(probe: Probe) -> str:
    """Say how a run ended, and whether undetected."""
    name = "wrong" if probe.outcome == "completed" else probe.outcome
    return f"{name} (undetected)" if probe.undetected else name


def span_text(probes: Sequence[Probe]) -> str:
    """Return the first and last value of some runs, `199 .. 31 steps`, or the only value."""
    first, last = probes[0].text, probes[-1].text
    if first == last:
        return first
    unit = last.partition(" ")[2]
    bare = unit[:1].isalpha() and first.endswith(f" {unit}")
    return f"{first.removesuffix(f' {unit}') if bare else first} .. {last}"


def undetected_words(walks: Iterable[Walk]) -> str:
    """Say how many runs are wrong and undetected, and on how many walks."""
    walked = [walk for walk in walks if walk.probes]
    runs = [probe for walk in walked for probe in walk.probes]
    affected = sum(any(probe.undetected for probe in walk.probes) for walk in walked)
    return f"{sum(probe.undetected for probe in runs)} of {len(runs)} runs, on {affected} of {len(walked)} walks"


def undetected_finding(walks: Iterable[Walk]) -> str:
    """Say in two sentences how many runs were wrong without a warning, and where; the first one in bold."""
    found = undetected_words(walks)
    runs, _, where = found.partition(" runs, on ")
    return f"**{runs} runs were wrong without any warning.** They lie on {where} (one axis, engine and preset each)."


def refusal_lines(walks: Iterable[Walk]) -> list[str]:
    """List the reasons why axes were not walked, each with its engines and presets."""
    refused: dict[str, list[str]] = {}
    for walk in walks:
        if walk.refusal:
            refused.setdefault(walk.refusal, []).append(" ".join(engine_and_preset(walk)))
    return [f"{reason} ({join_words(of)})" for reason, of in refused.items()]


def repeated_words(found: Sequence[Determinism]) -> list[str]:
    """List which engines and presets repeat runs to the last bit, and which runs differ."""
    same = [" ".join(engine_and_preset(one)) for one in found if one.identical and all(one.identical.values())]
    lines = [f"The same to the last bit: {join_words(same)}."] if same else []
    for one in found:
        differ = [run for run, identical in one.identical.items() if not identical]
        if differ or not one.identical:
            lines.append(
                f"{' '.join(engine_and_preset(one))}: {f'different {join_words(differ)}' if differ else one.outcome}."
            )
    return lines


# -- tables ----------------------------------------------------------------------------------------------------------


def limits_table(walks: Iterable[Walk], title: str = "") -> Table:
    """Return a row for each walk: how far each criterion holds, and how runs beyond 10 % ended."""
    rows = [
        (
            *(
                walk.axis,
                *engine_and_preset(walk),
                span_text(walk.probes) if walk.boundaries else f"{len(walk.probes)} values",
            ),
            *(boundary_text(walk, criterion) for criterion in BOUNDARIES),
            ", ".join(dict.fromkeys(ending_words(probe) for probe in walk.probes if not probe.good)) or NONE,
        )
        for walk in walks
        if walk.probes
    ]
    return table(("axis", *WHO, "from .. to", *BOUNDARIES.values(), BEYOND_ROUGH), rows, title=title, names=3)


def undetected_table(walks: Iterable[Walk]) -> Table:
    """Return a row for each axis and kind of wrong, undetected run, with its values.

    Runs that stay in one piece come first: they are the hardest to distinguish from a right motion.
    """
    groups: dict[tuple[str, str, str], list[tuple[Walk, tuple[Probe, ...]]]] = {}
    for walk in walks:
        for alike in probes_by_ending(walk):
            if alike[0].undetected:
                groups.setdefault((alike[0].level, walk.axis, alike[0].outcome), []).append((walk, alike))
    rows = []
    for (level, axis, outcome), found in sorted(groups.items(), key=lambda group: LEVELS.index(group[0][0])):
        ended = "ran to its end" if outcome == "completed" else f"`{outcome}`"
        places: dict[str, list[str]] = {}
        for walk, alike in found:
            places.setdefault(" ".join(engine_and_preset(walk)), []).append(span_text(alike))
        shown = "; ".join(f"{name}: {', '.join(where)}" for name, where in places.items())
        errors = [probe.position for _, alike in found for probe in alike if probe.position is not None]
        rows.append((axis, f"{level}, {ended}", shown, numbers.measured_text(max(errors, default=None))))
    return table(("axis", "result", "engines and presets, and where", LARGEST_ERROR), rows)


def probes_by_ending(walk: Walk) -> list[tuple[Probe, ...]]:
    """Group neighbouring runs of equal level, outcome and detection, from the safe end on."""
    return [tuple(probes) for _, probes in groupby(walk.probes, lambda p: (p.level, p.outcome, p.undetected))]


def onset_table(floats: Iterable[FollowerFloat]) -> Table:
    """Return a row for each engine and preset: the measured float speed over the theory's."""
    rows = []
    for found in floats:
        near = found.onset is not None and abs(found.onset - 1.0) <= ONSET_TOLERANCE
        verdict = f"{'' if near else 'not '}within {100 * ONSET_TOLERANCE:g} %"
        onset = numbers.MISSING if found.onset is None else f"{found.onset:.4f}"
        rows.append((*engine_and_preset(found), onset, verdict if near else ColouredCell(verdict, "bad")))
    return table((*WHO, "onset / theory", VERDICT), rows)
