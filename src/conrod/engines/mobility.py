"""Degrees of freedom that a compiled model's constraints leave along its whole motion: coordinates minus rank."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array

# Singular values below this share of the largest are zero: what is left of rounding is 1e-15 of it, a linkage a
# thousandth of a degree from a singular pose has 1e-5.
RANK_TOLERANCE = 1e-9


@dataclass(frozen=True)
class Row:
    """A scalar constraint equation of a compiled model: "z" of the closure "slider-pin"."""

    constraint: str
    part: str = ""

    def __str__(self) -> str:
        return f"{self.constraint} {self.part}".rstrip()


@dataclass(frozen=True)
class MobilityCount:
    """Count of a model over its motion. The drive, which prescribes the one freedom that is left, is not counted.

    Attributes:
        coordinates: degrees of freedom that the engine gives the bodies.
        rows: scalar equations of what holds them: joints that the engine solves for, closures, and one for each
            higher pair, the distance of cam and roller. What pushes but may part, friction, or a stray collision, is
            no equation of the mechanism.
        least_rank, most_rank: of the rows' Jacobian, over the motion. They differ at a singular pose.
        empty: rows that no coordinate enters at any angle: a planar model's share of a closure across its plane.
        redundant: constraint -> rows of it that say what rows before them say already, empty ones not among them.
    """

    coordinates: int
    rows: int
    least_rank: int
    most_rank: int
    empty: tuple[str, ...]
    redundant: Mapping[str, int]

    @property
    def freedom(self) -> int:
        """Degrees of freedom that are left, singular poses apart."""
        return self.coordinates - self.most_rank

    @property
    def most_freedom(self) -> int:
        """Degrees of freedom at the pose of least rank."""
        return self.coordinates - self.least_rank

    @property
    def missing(self) -> int:
        """Constraints that a machine with one driven crank lacks; 0 where it has one freedom, or none."""
        return max(self.freedom - 1, 0)


def count_mobility(rows: Sequence[Row], jacobians: Array) -> MobilityCount:
    """The count of a model from its Jacobians at poses of its motion.

    Args:
        rows: what the Jacobians' rows are, in the order that decides which of two equal ones is the redundant one.
        jacobians: (T, rows, coordinates), at least one.
    """
    ranks = [jacobian_rank(jacobian) for jacobian in jacobians]
    largest = float(np.abs(jacobians).max(initial=0.0))
    empty = [bool(np.abs(jacobians[:, i]).max(initial=0.0) <= RANK_TOLERANCE * largest) for i in range(len(rows))]
    # Where the rank is the largest, what depends on rows before it does so for good.
    kept = independent_rows(jacobians[int(np.argmax(ranks))])
    return MobilityCount(
        coordinates=jacobians.shape[2],
        rows=len(rows),
        least_rank=min(ranks),
        most_rank=max(ranks),
        empty=tuple(str(row) for row, none in zip(rows, empty, strict=True) if none),
        redundant=dict(
            Counter(row.constraint for row, none, new in zip(rows, empty, kept, strict=True) if not (none or new))
        ),
    )


def jacobian_rank(jacobian: Array) -> int:
    """Rank of a Jacobian (rows, coordinates) whose rows and columns may be in different units."""
    if not jacobian.size:
        return 0
    singular = np.linalg.svd(_scaled(jacobian), compute_uv=False)
    return int(np.sum(singular > RANK_TOLERANCE * singular[0])) if singular[0] > 0.0 else 0


def _scaled(jacobian: Array) -> Array:
    # A column in metres beside one in radians must not decide what is small.
    scale = np.linalg.norm(jacobian, axis=0)
    return np.asarray(jacobian / np.where(scale > 0.0, scale, 1.0))


def independent_rows(jacobian: Array) -> list[bool]:
    """Of each row, whether it says something that no row before it says."""
    found, before = [], 0
    for i in range(len(jacobian)):
        rank = jacobian_rank(jacobian[: i + 1])
        found.append(rank > before)
        before = max(rank, before)
    return found
