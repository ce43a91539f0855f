"""Closures that say what others say already."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from conrod.engines.mobility import jacobian_rank
from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.edits import Edit, Remove
from conrod.mjcf.lint.finding import Finding, Harm
from conrod.mjcf.lint.poses import Rows, closure_name
from conrod.mjcf.lint.rule import Rule
from conrod.own.models.loading import listed

# Two closures in the place of one are twice as stiff; what they close is then closed a little less tightly by one. A
# change of the motion by a millionth is that, and no other machine.
SAME_MOTION = 1e-6


def judge(bench: Bench) -> Iterator[Finding]:
    """Equalities without which the rank of all is the same at every pose, and rows that depend on others."""
    looks = bench.poses.rows
    redundant = min((int(rows.said.sum()) - rows.rank for rows in looks), default=0)
    if redundant <= 0:
        return
    whole = _whole(looks)
    if whole:
        yield _finding(bench, whole, redundant)
    else:
        yield _partly(bench, looks[0], redundant)


def _whole(looks: Sequence[Rows]) -> list[int]:
    """Equalities that can go together without anything becoming free, the later ones first."""
    gone: list[int] = []
    for index in sorted(set(looks[0].ids.tolist()), reverse=True):
        trial = [*gone, index]
        if all(_rank(rows, trial) == rows.rank for rows in looks) and _says_something(looks, index):
            gone = trial
    return gone


def _rank(rows: Rows, gone: list[int]) -> int:
    return jacobian_rank(rows.jacobian[~np.isin(rows.ids, gone)])


def _says_something(looks: Sequence[Rows], index: int) -> bool:
    return any(bool(rows.said[rows.ids == index].any()) for rows in looks)


def _finding(bench: Bench, gone: list[int], redundant: int) -> Finding:
    model, rows = bench.model, bench.poses.rows[0]
    names = [closure_name(model, index) for index in gone]
    edits: tuple[Edit, ...] = ()
    if all(bench.document.can_edit("equality", index) for index in gone):
        edits = tuple(Remove("equality", index, name) for index, name in zip(gone, names, strict=True))
    change = bench.change(edits) if edits else None
    return Finding(
        rule=RULE.name,
        subjects=tuple(names),
        what=f"without {listed(names)} the closures hold what they hold",
        harm=Harm.WASTE,
        evidence=(
            *_counts(rows, redundant),
            ("rank without", _rank(rows, gone)),
            ("change of motion without", change if change is not None else "not run"),
        ),
        why="forces are shared between closures that say the same: their reactions mean nothing, and where they do not "
        "agree to the last digit they fight",
        fix=f"leave out {listed(names)}",
        edits=edits,
        safe=change is not None and change <= SAME_MOTION,
        change=change,
        cost=bench.cost(edits) if edits else None,
    )


def _partly(bench: Bench, rows: Rows, redundant: int) -> Finding:
    """No equality as a whole is one too many, but some of their rows are."""
    dependent: list[str] = []
    kept: list[int] = []
    for row in (int(index) for index in np.flatnonzero(rows.said)):
        if jacobian_rank(rows.jacobian[[*kept, row]]) == len(kept) + 1:
            kept.append(row)
        else:
            first = int(np.flatnonzero(rows.ids == rows.ids[row])[0])
            name = closure_name(bench.model, int(rows.ids[row]))
            dependent.append(f"row {row - first + 1} of {name}")
    return Finding(
        rule=RULE.name,
        subjects=tuple(dependent),
        what=f"{redundant} rows of the closures say what others say: {listed(dependent)}",
        harm=Harm.WASTE,
        evidence=_counts(rows, redundant),
        why="forces are shared between rows that say the same: the reactions mean nothing, and a body that is made a "
        "little off fights itself",
        fix="let the bodies move in the plane of the machine only (hinges and slides), or tie each pin at one point",
    )


def _counts(rows: Rows, redundant: int) -> tuple[tuple[str, int], ...]:
    return (("constraint rows that say anything", int(rows.said.sum())), ("rank", rows.rank), ("redundant", redundant))


RULE = Rule("redundant-closure", judge)
