"""Each axis in plain words: safe here, wrong but quiet there, broken from there on; presets that are alike together."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from conrod.report.charts.styles import engine_title
from conrod.report.limits.words import MOST_TOLD, Passage, falling, passages, span_text
from conrod.report.markdown import listed
from conrod.studies.limits.grade import Level
from conrod.studies.limits.results import Probe, Walk

FEW = (
    2  # passages, of which walks can be told together though their boundaries differ; values that are named one by one
)
SHORT = 24  # characters of a value that is named
LEVELS = [level.slug for level in Level]


def sentences(walks: Sequence[Walk]) -> list[str]:
    """A sentence for each group of walks of one axis that pass through the same, in the same direction."""
    groups: dict[tuple[object, ...], list[Walk]] = {}
    for walk in walks:
        if walk.boundaries and walk.probes:
            groups.setdefault((falling(walk), _shape(walk)), []).append(walk)
    several = len({falling(walk) for walk in walks if len(walk.probes) > 1}) > 1
    return [_sentence(group, several) for group in groups.values()] + listed_sentences(walks)


def listed_sentences(walks: Sequence[Walk]) -> list[str]:
    """The same of walks over a list of values, where nothing lies between two of them."""
    told: dict[str, list[Walk]] = {}
    for walk in walks:
        if walk.probes and not walk.boundaries:
            told.setdefault(_counted(walk), []).append(walk)
    return [f"{names_of(group)}: {text}." for text, group in told.items()]


def _counted(walk: Walk) -> str:
    alike: dict[str, list[Probe]] = {}
    for probe in sorted(walk.probes, key=lambda probe: LEVELS.index(probe.level)):
        alike.setdefault(_condition(Passage(probe.level, probe.undetected, (probe,))), []).append(probe)
    if len(alike) == 1:
        return f"{next(iter(alike))} throughout ({len(walk.probes)} runs)"
    return ", ".join(f"{condition} {_which(found, len(walk.probes))}" for condition, found in alike.items())


def _which(probes: Sequence[Probe], of: int) -> str:
    """Few values by what they are called, where that is short; many by their number."""
    names = [probe.text for probe in probes]
    if len(names) <= FEW and max(map(len, names)) <= SHORT:
        return f"at {listed(names)}"
    return f"in {len(names)} of {of} runs"


def _shape(walk: Walk) -> tuple[object, ...]:
    """What walks have in common that one sentence can tell: all of it, or, of few passages, all but where they end."""
    found = passages(walk)
    kinds = tuple(passage.kind for passage in found)
    if len(found) <= FEW:
        return (kinds, walk.engine if len(found) > 1 else "")
    return (kinds, tuple((p.probes[0].text, p.probes[-1].text) for p in found))


def _sentence(walks: Sequence[Walk], several: bool) -> str:
    towards = f", towards {walks[0].probes[-1].text}" if several else ""
    found = [passages(walk) for walk in walks]
    told = _comes_and_goes(walks[0]) if len(found[0]) > MOST_TOLD else _in_turn(walks, found)
    return f"{names_of(walks)}{towards}: {told}."


def names_of(walks: Iterable[Walk]) -> str:
    """Engines, each with its presets: MuJoCo `tuned` and `hardened`, pymunk `stock`."""
    presets: dict[str, list[str]] = {}
    for walk in walks:
        presets.setdefault(walk.engine, []).append(f"`{walk.preset}`")
    return "; ".join(f"{engine_title(engine)} {listed(names)}" for engine, names in presets.items())


def _in_turn(walks: Sequence[Walk], found: Sequence[Sequence[Passage]]) -> str:
    """All passages of walks that have the same ones, in turn."""
    count = len(found[0])
    if count == 1:
        whole = "throughout" if len(walks[0].probes) > 1 else f"at {walks[0].probes[0].text}, where it ended"
        return f"{_condition(found[0][0])} {whole}"
    way = "down to" if falling(walks[0]) else "up to"
    return ", ".join(_part([passes[k] for passes in found], walks, way, k == count - 1) for k in range(count))


def _part(these: Sequence[Passage], walks: Sequence[Walk], way: str, last: bool) -> str:
    """What the same passage of some walks is told as; the last one goes on to the end of the axis."""
    first, end = ([p.probes[k].text for p in these] for k in (0, -1))
    if first == end:
        told = f"at {_values(walks, first)}"
    elif last:
        told = f"from {_values(walks, first)} on"
    elif these[0].good:
        told = f"{way} {_values(walks, end)}"
    else:
        told = _values(walks, [_from_to(p.probes) for p in these])
    return f"{_condition(these[0])} {told}"


def _comes_and_goes(walk: Walk) -> str:
    """A walk with many passages: what holds before the first bad run, and all that is met beyond."""
    found = passages(walk)
    # Where all is good, it comes and goes between safe and rough.
    first = next((k for k, passage in enumerate(found) if not passage.good), 1)
    way = "down to" if falling(walk) else "up to"
    before = [f"{_condition(p)} {way} {p.probes[-1].text}" for p in found[:first]]
    beyond = found[first:]
    met = listed(list(dict.fromkeys(_condition(p) for p in beyond)))
    return ", ".join([*before, f"from {beyond[0].probes[0].text} on it comes and goes: {met}"])


def _condition(passage: Passage) -> str:
    """In what condition the motion is; what is dangerous is bold."""
    ended = [outcome for outcome in passage.outcomes if outcome != "completed"]
    how = f" ({listed(ended)})" if ended else ""
    if passage.undetected:
        return f"**{passage.level} but quiet**{how}"
    return f"wrong, and the engine warns{how}" if passage.level == "wrong" else f"{passage.level}{how}"


def _from_to(probes: Sequence[Probe]) -> str:
    only = probes[0].text == probes[-1].text
    return f"at {probes[0].text}" if only else f"from {span_text(probes, ' to ')}"


def _values(walks: Sequence[Walk], texts: Sequence[str]) -> str:
    """One text for all walks, or each with its walk's name."""
    if len(set(texts)) == 1:
        return texts[0]
    names: dict[str, list[str]] = {}
    for walk, text in zip(walks, texts, strict=True):
        names.setdefault(text, []).append(f"`{walk.preset}`")
    return " or ".join(f"{text} ({listed(who)})" for text, who in names.items())
