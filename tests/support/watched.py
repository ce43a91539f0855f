"""Watched runs, and defects planted in their pieces."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from conrod.engines import engine_named
from conrod.runs.trajectory import Piece
from conrod.studies.frame.case import Measurement
from conrod.studies.limits import stream_run as watching
from conrod.studies.limits.case import LimitCase
from conrod.studies.limits.records import Extremes
from conrod.studies.limits.stream_run import stream_run


def cell(scene: Any, settings: Any, revolutions: float = 2.0, start_angle: float = 0.0) -> LimitCase:
    return LimitCase("a machine", scene, settings, revolutions, start_angle)


@cache
def watched(scene: Any, settings: Any, revolutions: float = 2.0) -> Measurement:
    return stream_run(cell(scene, settings, revolutions))


def extremes(measurement: Measurement) -> Extremes:
    assert measurement.extremes is not None
    return Extremes.of(measurement)


def coarse_cam(settings: Any) -> Any:
    """A cam of few facets is made sooner."""
    return replace(settings, cam_vertices=400)


def in_pieces_of(monkeypatch: pytest.MonkeyPatch, steps: int) -> None:
    monkeypatch.setattr(watching, "piece_length", lambda _: steps)


def planted_in(
    monkeypatch: pytest.MonkeyPatch, engine: str, number: int, defect: Callable[[Piece], Piece], *, on: bool = False
) -> None:
    """A defect in one piece of every run of an engine, or from that piece on."""
    pieces = engine_named(engine).run

    def planted(*args: Any) -> Iterator[Piece]:
        for k, piece in enumerate(pieces(*args)):
            yield defect(piece) if k == number or (on and k > number) else piece

    monkeypatch.setattr(engine_named(engine), "run", planted)


def moved(piece: Piece, distance: float) -> Piece:
    """With the last position of point C moved."""
    tracks = piece.trajectory.points["C"]
    values = tracks.position.values.copy()
    values[-1, 0] += distance
    position = replace(tracks.position, values=values)
    points = {**piece.trajectory.points, "C": replace(tracks, position=position)}
    return replace(piece, trajectory=replace(piece.trajectory, points=points))
