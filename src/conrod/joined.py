"""Consecutive pieces of a run as one: a comparison of many samples at once costs little more than that of a few."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from conrod.trajectory import BodyStates, BodyTracks, Instants, Piece, PointTracks, Track

Part = TypeVar("Part", Instants, Track, PointTracks, BodyStates, BodyTracks)


def joined(pieces: Sequence[Piece]) -> Piece:
    """One piece of all their samples; outcome, warnings and solver are those of the last one."""
    if len(pieces) == 1:
        return pieces[0]
    first, last, join = pieces[0], pieces[-1], _Join()
    bodies = [piece.trajectory.bodies for piece in pieces]
    points = {name: join([piece.trajectory.points[name] for piece in pieces]) for name in last.trajectory.points}
    torques = [piece.drive_torque for piece in pieces]
    return replace(
        last,
        trajectory=replace(last.trajectory, points=points, bodies=join([b for b in bodies if b is not None])),
        first_step=first.first_step,
        clock=np.concatenate([piece.clock for piece in pieces]),
        drive_torque=None if last.drive_torque is None else np.concatenate([t for t in torques if t is not None]),
    )


class _Join:
    """Joins arrays, and what is made of them, field by field; what several tracks share they share afterwards."""

    def __init__(self) -> None:
        self._known: dict[tuple[int, ...], Any] = {}

    def __call__(self, parts: Sequence[Part]) -> Part:
        key = tuple(id(part) for part in parts)
        if key not in self._known:
            self._known[key] = type(parts[0])(
                *(self._field([getattr(part, field.name) for part in parts]) for field in fields(parts[0]))
            )
        found: Part = self._known[key]
        return found

    def _field(self, values: Sequence[Any]) -> Any:
        return np.concatenate(values) if isinstance(values[0], np.ndarray) else self(values)
