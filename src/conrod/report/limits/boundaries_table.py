"""Up to where each engine and preset can be relied on along one axis, and what was not walked."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.limits.words import BOUNDARIES, beyond, largest_error, span_text, up_to
from conrod.report.markdown import listed
from conrod.report.tables import paragraphs, table
from conrod.studies.limits.results import Probe, Walk

NO_SOLVER_NOTE = "-"
RESIDUAL = ", residual above "  # in a note, before its power of ten; see `conrod.studies.limits.solver_notes`
FEW = 3  # values of a list, each of which gets a column
HELD_AGAIN = "\\* further on there are runs that keep the criterion."


def boundaries_table(walks: Sequence[Walk]) -> str:
    """The boundaries of all walks of an axis; of a list of values how many ended how."""
    with_boundaries = [walk for walk in walks if walk.boundaries]
    if not with_boundaries:
        return _listed_table([walk for walk in walks if walk.probes])
    noted = any(probe.solver for walk in with_boundaries for probe in walk.probes)
    head = ["engine", "preset", "from .. to", *BOUNDARIES.values(), "beyond 10 %", *(["its solver"] if noted else [])]
    rows = [
        [
            *_name(walk),
            span_text(walk.probes),
            *(up_to(walk, criterion) for criterion in BOUNDARIES),
            beyond(walk) or NO_SOLVER_NOTE,
            *([solver_notes(walk.probes) or NO_SOLVER_NOTE] if noted else []),
        ]
        for walk in with_boundaries
    ]
    again = any(boundary.good_again for walk in with_boundaries for boundary in walk.boundaries)
    return paragraphs(table(head, rows), HELD_AGAIN if again else "")


def _listed_table(walks: Sequence[Walk]) -> str:
    """Few values each in a column of its own, many counted."""
    if max((len(walk.probes) for walk in walks), default=0) <= FEW:
        head = [f"{probe.text}: position error / L" for probe in walks[0].probes] if walks else []
        return table(["engine", "preset", *head], [[*_name(walk), *map(_shown, walk.probes)] for walk in walks])
    return _counted_table(walks)


def _shown(probe: Probe) -> str:
    """The error of a run, or how it ended, and whether quietly."""
    error = probe.outcome if probe.errors is None else numbers.measured(probe.errors["position"])
    return f"{error} (undetected)" if probe.undetected else error


def _counted_table(walks: Sequence[Walk]) -> str:
    noted = any(probe.solver for walk in walks for probe in walk.probes)
    head = ["engine", "preset", "runs", "within 10 %", "largest position error / L", "ended otherwise"]
    rows = [
        [
            *_name(walk),
            str(len(walk.probes)),
            str(sum(probe.level in ("safe", "rough") for probe in walk.probes)),
            numbers.measured(largest_error(walk.probes)),
            _ends(walk) or NO_SOLVER_NOTE,
            *([solver_notes(walk.probes) or NO_SOLVER_NOTE] if noted else []),
        ]
        for walk in walks
    ]
    return table([*head, *(["its solver"] if noted else [])], rows)


def _ends(walk: Walk) -> str:
    """How runs of a list ended that did not complete: 3 opened, 1 diverged."""
    ends: dict[str, int] = {}
    for probe in walk.probes:
        if probe.outcome != "completed":
            ends[probe.outcome] = ends.get(probe.outcome, 0) + 1
    return ", ".join(f"{count} {outcome}" for outcome, count in ends.items())


def solver_notes(probes: Sequence[Probe]) -> str:
    """What is to be said of the solver, of which values it is said, and between which powers of ten its residual is."""
    where: dict[str, list[tuple[Probe, str]]] = {}
    for probe in probes:
        if probe.solver:
            note, _, residual = probe.solver.partition(RESIDUAL)
            where.setdefault(note, []).append((probe, residual))
    return "; ".join(_noted(note, of, len(probes)) for note, of in where.items())


def _noted(note: str, of: Sequence[tuple[Probe, str]], among: int) -> str:
    residuals = sorted({residual for _, residual in of if residual}, key=float)
    left = f"{RESIDUAL}{residuals[0]}" if residuals else ""
    up_to = f" to {residuals[-1]}" if len(residuals) > 1 else ""
    return f"{note}: {span_text([probe for probe, _ in of])} ({len(of)} of {among} runs){left}{up_to}"


def refusals(walks: Sequence[Walk]) -> list[str]:
    """Why an axis was not walked, each reason once, with those that it is for."""
    who: dict[str, dict[str, list[str]]] = {}
    for walk in walks:
        if walk.refusal:
            who.setdefault(walk.refusal, {}).setdefault(walk.engine, []).append(f"`{walk.preset}`")
    return [
        f"Not walked with {'; '.join(f'{engine_title(e)} {listed(presets)}' for e, presets in of.items())}: {reason}."
        for reason, of in who.items()
    ]


def _name(walk: Walk) -> list[str]:
    return [engine_title(walk.engine), walk.preset]
