"""Tables of a report of limits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.limits.words import (
    BOUNDARIES,
    EVERYWHERE,
    WHO,
    beyond,
    fails_from,
    largest_error,
    listed,
    not_held,
    span_text,
    up_to,
    who,
)
from conrod.report.table import Cell, Table, Toned, table
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.determinism import RUNS, Determinism
from conrod.studies.limits.grade import LEVELS
from conrod.studies.limits.maps import LimitMap, standing
from conrod.studies.limits.results import IterationNeed, LimitStudy, Probe, Stretch, Walk, stretches

NONE = "-"
LARGEST = "largest position error / L"
FEW = 3  # values of a list, each of which gets a column
MOST_NAMED = 4  # values of a list that are given one by one
RESIDUAL = ", residual above "  # in a note on the solver, before its power of ten


# -- on the terminal -------------------------------------------------------------------------------------------------


def limits_table(study: LimitStudy) -> Table:
    """Return the boundaries of all walks of a scene."""
    walks = [walk for walk in study.walks if walk.boundaries]
    rows = [(w.axis, w.engine, w.preset, *(up_to(w, c) for c in BOUNDARIES), beyond(w)) for w in walks]
    title = f"{study.name}: holds up to (undetected: finite numbers, no warning, wrong motion)"
    return table(("axis", *WHO, *BOUNDARIES.values(), "beyond that"), rows, title=title)


def listed_lines(study: LimitStudy) -> list[str]:
    """Return a line for each walk over a list of values: how many ended well, and which did not."""
    lines = []
    for walk in study.walks:
        if walk.probes and not walk.boundaries:
            bad = [f"{probe.text} {probe.outcome}" for probe in walk.probes if not probe.good]
            held = f"{len(walk.probes) - len(bad)} of {len(walk.probes)} within 10 %"
            lines.append(f"{walk.axis}, {walk.engine} {walk.preset}: {held}" + (f"; {', '.join(bad)}" if bad else ""))
    return lines


def refused_lines(study: LimitStudy) -> list[str]:
    """Return a line for each axis that was not walked in an engine."""
    refused = dict.fromkeys((w.axis, w.engine, w.refusal) for w in study.walks if w.refusal)
    return [f"{axis}, {engine}: not walked, {reason}" for axis, engine, reason in refused]


# -- one axis --------------------------------------------------------------------------------------------------------


def boundaries_table(walks: Sequence[Walk]) -> Table:
    """Return the boundaries of all walks of an axis; of a list of values how many ended how."""
    bounded = [walk for walk in walks if walk.boundaries]
    if not bounded:
        return _listed_table([walk for walk in walks if walk.probes])
    noted = any(probe.solver for walk in bounded for probe in walk.probes)
    head = [*WHO, "from .. to", *BOUNDARIES.values(), "beyond 10 %", "fails from", *(["its solver"] if noted else [])]
    rows = [
        [
            *(*who(w), span_text(w.probes)),
            *(up_to(w, c) for c in BOUNDARIES),
            *(beyond(w) or NONE, fails_from(w) or NONE),
            *_note(w, noted),
        ]
        for w in bounded
    ]
    return table(head, rows)


def _listed_table(walks: Sequence[Walk]) -> Table:
    """Few values each in a column of its own, many counted."""
    if max((len(walk.probes) for walk in walks), default=0) <= FEW:
        head = [f"{probe.text}: position error / L" for probe in walks[0].probes] if walks else []
        return table([*WHO, *head], [[*who(walk), *map(_shown, walk.probes)] for walk in walks])
    noted = any(probe.solver for walk in walks for probe in walk.probes)
    head = [*WHO, "runs", "within 10 %", LARGEST, "ended otherwise", *(["its solver"] if noted else [])]
    rows = [
        [
            *who(walk),
            str(len(walk.probes)),
            str(sum(probe.good for probe in walk.probes)),
            numbers.measured(largest_error(walk.probes)),
            _ends(walk) or NONE,
            *_note(walk, noted),
        ]
        for walk in walks
    ]
    return table(head, rows)


def _shown(probe: Probe) -> str:
    error = probe.outcome if probe.position is None else numbers.measured(probe.position)
    return f"{error} (undetected)" if probe.undetected else error


def _ends(walk: Walk) -> str:
    """Outcomes of runs of a list that did not complete: 3 opened, 1 diverged."""
    ends = Counter(probe.outcome for probe in walk.probes if probe.outcome != "completed")
    return ", ".join(f"{count} {outcome}" for outcome, count in ends.items())


def _note(walk: Walk, noted: bool) -> list[str]:
    return [solver_notes(walk.probes) or NONE] if noted else []


def solver_notes(probes: Sequence[Probe]) -> str:
    """Return each note on the solver, its values, and between which powers of ten its residual is."""
    where: dict[str, list[tuple[Probe, str]]] = {}
    for probe in probes:
        if probe.solver:
            note, _, residual = probe.solver.partition(RESIDUAL)
            where.setdefault(note, []).append((probe, residual))
    return "; ".join(_noted(note, of, len(probes)) for note, of in where.items())


def _noted(note: str, of: Sequence[tuple[Probe, str]], among: int) -> str:
    residuals = sorted({residual for _, residual in of if residual}, key=float)
    left = f"{RESIDUAL}{residuals[0]}" if residuals else ""
    to = f" to {residuals[-1]}" if len(residuals) > 1 else ""
    return f"{note}: {span_text([probe for probe, _ in of])} ({len(of)} of {among} runs){left}{to}"


def refusals(walks: Iterable[Walk]) -> list[str]:
    """Return why an axis was not walked, each reason once, with those that it is for."""
    refused: dict[str, dict[str, list[str]]] = {}
    for walk in walks:
        if walk.refusal:
            refused.setdefault(walk.refusal, {}).setdefault(walk.engine, []).append(f"`{walk.preset}`")
    return [
        f"Not walked with {'; '.join(f'{engine_title(e)} {listed(presets)}' for e, presets in of.items())}: {reason}."
        for reason, of in refused.items()
    ]


def torque_notes(walks: Iterable[Walk]) -> list[str]:
    """Return, for each walk, the error of the drive torque at both ends and where it is least."""
    notes = []
    for walk in walks:
        known = [(probe.torque, probe.text) for probe in walk.probes if probe.torque is not None]
        if known:
            (first, begin), (least, where), (last, end) = known[0], min(known), known[-1]
            notes.append(
                f"{engine_title(walk.engine)} `{walk.preset}`: the drive torque is off by {numbers.measured(first)} of "
                f"its peak at {begin}, by {numbers.measured(last)} at {end}, and least, by {numbers.measured(least)}, "
                f"at {where}."
            )
    return notes


def reference_note(walks: Iterable[Walk]) -> str:
    """Return how far the reference itself is off at worst; nothing where it is at its usual rounding."""
    known = [(p.reference_error, p.text) for walk in walks for p in walk.probes if p.reference_error is not None]
    if not known:
        return ""
    worst, where = max(known, key=lambda pair: pair[0])
    return f"The reference itself is off by at most {numbers.measured(worst)} L, at {where}."


# -- wrong and undetected --------------------------------------------------------------------------------------------


def undetected_table(walks: Iterable[Walk]) -> Table:
    """Return a row for each axis and way of being wrong, with who is so and where.

    A motion in one piece comes first: it is the hardest to distinguish from a right one.
    """
    groups: dict[tuple[str, str, str], list[tuple[Walk, Stretch]]] = {}
    for walk in walks:
        for stretch in _undetected(walk):
            groups.setdefault((stretch.level, walk.axis, stretch.outcome), []).append((walk, stretch))
    rows = []
    for (level, axis, outcome), found in sorted(groups.items(), key=lambda group: LEVELS.index(group[0][0])):
        ended = "ran to its end" if outcome == "completed" else f"`{outcome}`"
        places: dict[str, list[str]] = {}
        for walk, stretch in found:
            places.setdefault(" ".join(who(walk)), []).append(_where(walk, stretch))
        shown = "; ".join(f"{name}: {', '.join(where)}" for name, where in places.items())
        largest = largest_error(probe for _, stretch in found for probe in stretch.probes)
        rows.append((AXES[axis].title, f"{level}, {ended}", shown, numbers.measured(largest)))
    return table(("axis", "result", "engines and presets, and where", LARGEST), rows)


def _undetected(walk: Walk) -> list[Stretch]:
    if walk.boundaries:
        return [stretch for stretch in stretches(walk) if stretch.undetected]
    # Values of a list are no neighbours: those that ended alike are taken together, wherever they stand.
    alike: dict[tuple[str, str], list[Probe]] = {}
    for probe in walk.probes:
        if probe.undetected:
            alike.setdefault((probe.level, probe.outcome), []).append(probe)
    return [Stretch(tuple(probes)) for probes in alike.values()]


def _where(walk: Walk, stretch: Stretch) -> str:
    if walk.boundaries or len(stretch.probes) == 1:
        return span_text(stretch.probes)
    named = ", ".join(probe.text for probe in stretch.probes[:MOST_NAMED])
    more = len(stretch.probes) - MOST_NAMED
    return f"{len(stretch.probes)} of {len(walk.probes)}: {named}" + (f" and {more} more" if more > 0 else "")


# -- steps, maps, iterations, repeated and long runs -----------------------------------------------------------------


def steps_table(walks: Iterable[Walk]) -> Table:
    """Return a row for each scene, engine and preset whose steps were walked."""
    rows = [
        (walk.scene, *who(walk), *(_steps_held(walk, criterion) for criterion in BOUNDARIES))
        for walk in walks
        if walk.axis == "steps" and walk.boundaries
    ]
    return table(("machine", *WHO, *BOUNDARIES.values()), rows)


def _steps_held(walk: Walk, criterion: str) -> str:
    """The last number of steps that keeps a criterion, and how the next one ended: `34 (33: opened, undetected)`."""
    boundary = walk.boundary(criterion)
    if boundary.first_bad is None:
        return EVERYWHERE
    bad = next(probe for probe in walk.probes if probe.value == boundary.first_bad)
    ended = bad.level if bad.outcome == "completed" else bad.outcome
    held = not_held(boundary) if boundary.last_good is None else f"{boundary.last_good:g}"
    return f"{held} ({bad.value:g}: {ended}{', undetected' if boundary.undetected else ''})"


def maps_table(maps: Iterable[LimitMap]) -> Table:
    """Return a row for each map: how many of its nodes were run, and of what its areas are."""
    standings = list(dict.fromkeys(map(standing, LEVELS)))
    rows = []
    for found in maps:
        counted = Counter(standing(run.level) for run in found.shown.values())
        axes = (AXES[found.x_axis].title, AXES[found.y_axis].title)
        shares = (numbers.percent(counted[name] / found.nodes) for name in standings)
        run = (str(found.nodes), str(len(found.runs)), numbers.percent(found.share))
        rows.append((*who(found), *axes, *run, *shares))
    return table((*WHO, "across", "upwards", "nodes", "runs", "share", *(f"{name} nodes" for name in standings)), rows)


def needs_table(needs: Iterable[IterationNeed]) -> Table:
    """Return a row for each number of iterations and each way from equal masses."""
    rows = []
    for need in needs:
        for walk in need.walks:
            slider, held = (
                "lighter" if walk.falling else "heavier",
                (up_to(walk, criterion) for criterion in BOUNDARIES),
            )
            rows.append((*who(need), str(need.iterations), slider, *held, beyond(walk) or NONE))
    return table((*WHO, "iterations", "slider", *BOUNDARIES.values(), "beyond 10 %"), rows)


SHOWN = 12  # hexadecimal digits of a fingerprint


def determinism_table(found: Iterable[Determinism]) -> Table:
    """Return a row for each engine and preset."""
    rows = []
    for one in found:
        first = one.fingerprints.get(RUNS[0])
        fingerprint = numbers.MISSING if first is None else f"`{first[:SHOWN]}`"
        rows.append((*who(one), *(_same(one.identical.get(run)) for run in RUNS[1:]), one.outcome, fingerprint))
    return table((*WHO, "again in one process", *RUNS[2:], "ended", "fingerprint"), rows)


def _same(identical: bool | None) -> Cell:
    return numbers.MISSING if identical is None else "identical" if identical else Toned("different", "bad")
