"""Walks in words: boundaries, stretches, and a sentence of findings for each axis."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from conrod.report.charts.styles import engine_title
from conrod.report.limits.axis_scale import place
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.grade import ROUGH_ERROR, SAFE_ERROR
from conrod.studies.limits.results import Boundary, LimitStudy, Probe, Stretch, Walk, stretches

# Criterion -> the heading of its column.
BOUNDARIES = {
    "safe": f"within {100 * SAFE_ERROR:g} %",
    "rough": f"within {100 * ROUGH_ERROR:g} %",
    "wrong": "in one piece",
    "broken": "bounded",
}
EVERYWHERE, NOWHERE, NOT_AT_FIRST = "all of it", "none of it", "not at first"
AGAIN = " *"  # after a value: there are runs further on that keep the criterion
CRITERION = "rough"  # the boundary of the findings: where the error exceeds ten per cent


WHO = ("engine", "preset")


def who(finding: Any) -> tuple[str, str]:
    """Return engine and preset, for the first cells of a row."""
    return engine_title(finding.engine), finding.preset


def listed(names: Sequence[str]) -> str:
    """Return names as a sentence has them: a, b and c."""
    return " and ".join(part for part in (", ".join(names[:-1]), names[-1]) if part) if names else ""


def names_of(walks: Iterable[Walk]) -> str:
    """Return engines, each with its presets: MuJoCo `tuned` and `hardened`; pymunk `stock`."""
    presets: dict[str, list[str]] = {}
    for walk in walks:
        presets.setdefault(walk.engine, []).append(f"`{walk.preset}`")
    return "; ".join(f"{engine_title(engine)} {listed(names)}" for engine, names in presets.items())


def by_axis(walks: Iterable[Walk]) -> dict[str, list[Walk]]:
    """Return walks by the names of their axes, in their order."""
    found: dict[str, list[Walk]] = {}
    for walk in walks:
        found.setdefault(walk.axis, []).append(walk)
    return found


def largest_error(probes: Iterable[Probe]) -> float | None:
    """Return the largest position error of the runs that completed; None where none did."""
    return max((probe.position for probe in probes if probe.position is not None), default=None)


def up_to(walk: Walk, criterion: str) -> str:
    """Return the last value at which a criterion holds, coming from the safe end."""
    boundary = walk.boundary(criterion)
    if boundary.first_bad is None:
        return EVERYWHERE
    held = not_held(boundary) if boundary.last_good is None else walk.text_at(boundary.last_good)
    return held + (AGAIN if boundary.good_again else "")


def not_held(boundary: Boundary) -> str:
    """Return words for a criterion that not even the safe end keeps: whether any run does."""
    return NOT_AT_FIRST if boundary.good_again else NOWHERE


def beyond(walk: Walk) -> str:
    """Return how the runs beyond ten per cent ended, from the safe end on."""
    return ", ".join(dict.fromkeys(how(stretch) for stretch in stretches(walk) if not stretch.good))


def fails_from(walk: Walk) -> str:
    """Return the first value of each ending beyond ten per cent, in the order of `beyond`."""
    first: dict[str, str] = {}
    for stretch in stretches(walk):
        if not stretch.good:
            first.setdefault(how(stretch), stretch.probes[0].text)
    return ", ".join(first.values())


def how(ended: Stretch | Probe) -> str:
    """Return how a run ended, and whether undetected."""
    name = "wrong" if ended.outcome == "completed" else ended.outcome
    return f"{name} (undetected)" if ended.undetected else name


def span_text(probes: Sequence[Probe]) -> str:
    """Return the first and the last value of some runs, as `199 .. 31 steps`, or the only one."""
    first, last = probes[0].text, probes[-1].text
    if first == last:
        return first
    unit = last.partition(" ")[2]
    bare = unit[:1].isalpha() and first.endswith(f" {unit}")
    return f"{first.removesuffix(f' {unit}') if bare else first} .. {last}"


# -- findings --------------------------------------------------------------------------------------------------------


def undetected_words(walks: Iterable[Walk]) -> str:
    """Return how many runs are wrong and undetected, and on how many walks."""
    walked = [walk for walk in walks if walk.probes]
    runs = [probe for walk in walked for probe in walk.probes]
    affected = sum(any(probe.undetected for probe in walk.probes) for walk in walked)
    return f"{sum(probe.undetected for probe in runs)} of {len(runs)} runs, on {affected} of {len(walked)} walks"


def elsewhere_words(study: LimitStudy) -> str:
    """Return how many undetected runs there are beside the walks: on maps, and with iterations that stay."""
    on_maps = [run.undetected for found in study.maps for run in found.runs]
    iterated = [probe.undetected for need in study.needs for walk in need.walks for probe in walk.probes]
    counted: Mapping[str, list[bool]] = {"of the maps": on_maps, "with iterations that stay": iterated}
    said = [f"{sum(runs)} of {len(runs)} runs {which}" for which, runs in counted.items() if any(runs)]
    return f"So are {listed(said)}." if said else ""


def findings(walks: Iterable[Walk]) -> list[str]:
    """Return a sentence for each axis and direction that has boundaries: how far the error stays within 10 %."""
    sentences = []
    for axis, walked in by_axis(walks).items():
        ways: dict[bool, list[Walk]] = {}
        for walk in walked:
            if walk.boundaries:
                ways.setdefault(walk.falling, []).append(walk)
        sentences += [f"**{AXES[axis].title}**, {span_text(way[0].probes)}: {_reached(way)}." for way in ways.values()]
    return sentences


def _reached(walks: Sequence[Walk]) -> str:
    """Words on how far ten per cent holds, for the furthest and the least far, in one direction of an axis."""
    left = [walk for walk in walks if walk.boundary(CRITERION).first_bad is not None]
    throughout = [walk for walk in walks if walk not in left]
    if not left:
        return f"within 10 % throughout with {'every preset' if len(walks) > 1 else names_of(walks)}"
    unheld = [walk for walk in left if walk.boundary(CRITERION).last_good is None]
    nowhere = [walk for walk in unheld if not walk.boundary(CRITERION).good_again]
    late = [walk for walk in unheld if walk not in nowhere]
    somewhere = sorted((walk for walk in left if walk not in unheld), key=_reach)
    parts = [f"within 10 % throughout with {names_of(throughout)}"] if throughout else []
    if somewhere and not throughout and _reach(somewhere[-1]) > _reach(somewhere[0]):
        parts.append(f"within 10 % furthest with {names_of(_equal(somewhere, -1))} ({_limit(somewhere[-1])})")
    if somewhere:
        least = "least far" if parts else "within 10 %"
        parts.append(f"{least} with {names_of(_equal(somewhere, 0))} ({_limit(somewhere[0])})")
    if nowhere:
        parts.append(f"nowhere with {names_of(nowhere)}")
    if late:
        parts.append(f"not at first, but further on with {names_of(late)}")
    return f"{', '.join(parts)}; {_undetected(left)}"


def _undetected(left: Sequence[Walk]) -> str:
    """Number of those that leave ten per cent do so undetected."""
    count = sum(walk.boundary(CRITERION).undetected for walk in left)
    if count == 0:
        return "none leaves it undetected"
    return "all that leave it do so undetected" if count == len(left) else f"{count} of {len(left)} leave it undetected"


def _equal(walks: Sequence[Walk], k: int) -> list[Walk]:
    """All that reach as far as one of them."""
    return [walk for walk in walks if _reach(walk) == _reach(walks[k])]


def _reach(walk: Walk) -> float:
    """Distance to which ten per cent holds, along the axis' own scale."""
    scale, last = AXES[walk.axis].scale, walk.boundary(CRITERION).last_good
    return 0.0 if last is None else abs(place(scale, last) - place(scale, walk.probes[0].value))


def _limit(walk: Walk) -> str:
    last = walk.boundary(CRITERION).last_good
    assert last is not None
    return ("down to " if walk.falling else "up to ") + walk.text_at(last)
