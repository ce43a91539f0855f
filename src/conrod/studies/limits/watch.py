"""A run at an engine's limits: streamed, compared as it goes, and watched for how it fails."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field

import numpy as np

from conrod.comparison import QUANTITIES, Comparison, compare
from conrod.engines import engine_named
from conrod.motion import Array
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.extremes import Extremes
from conrod.studies.measurement import Measurement
from conrod.trajectory import Outcome, Piece, Trajectory


def watch(cell: LimitCell) -> Measurement:
    """Run a cell in pieces, up to its end or to the piece in which it failed.

    Raises:
        InvalidInput: as `conrod.run`.
    """
    engine = engine_named(cell.settings.engine)
    refusal = engine.refusal(cell.machine, cell.settings)
    if refusal:
        return Measurement(Outcome.UNSUPPORTED.slug, refusal)
    seen = _Seen()
    for piece in engine.pieces(cell.machine, cell.settings, cell.revolutions, cell.start_angle):
        seen.add(piece)
        if piece.trajectory.outcome is not Outcome.COMPLETED:
            return seen.failed(piece.trajectory)
        seen.compare(compare(piece.trajectory, cell.machine))
    return seen.completed()


@dataclass
class _Sizes:
    """Max, rms and final value of a series that comes in pieces."""

    largest: float = 0.0
    squares: float = 0.0
    count: int = 0
    final: float = 0.0

    def add(self, values: Array) -> None:
        if len(values) == 0:
            return
        self.largest = max(self.largest, float(values.max()))
        self.squares += float(values @ values)
        self.count += len(values)
        self.final = float(values[-1])

    def as_dict(self) -> dict[str, float]:
        return {"max": self.largest, "rms": float(np.sqrt(self.squares / max(self.count, 1))), "final": self.final}


@dataclass
class _Seen:
    """What the pieces so far have shown."""

    samples: int = 0
    finite: bool = True
    warnings: dict[str, int] = field(default_factory=dict)
    errors: dict[str, dict[str, _Sizes]] = field(default_factory=dict)
    closure: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(("position", "velocity", "acceleration"), 0.0)
    )
    phase: _Sizes = field(default_factory=_Sizes)
    drive: dict[str, float] = field(default_factory=lambda: {"speed": 0.0, "acceleration": 0.0})
    digest: hashlib._Hash = field(default_factory=hashlib.sha256)

    def add(self, piece: Piece) -> None:
        """Count a piece, whatever became of it."""
        bodies = piece.trajectory.bodies
        assert bodies is not None
        self.samples += len(bodies.position.poses)
        self.warnings = dict(piece.warnings)
        for values in _recorded(piece.trajectory):
            self.finite = self.finite and bool(np.all(np.isfinite(values)))
            self.digest.update(np.ascontiguousarray(values).tobytes())

    def compare(self, found: Comparison) -> None:
        """Take in the errors of a piece."""
        for name, point in found.points.items():
            sizes = self.errors.setdefault(name, {q: _Sizes() for q in QUANTITIES})
            for quantity in QUANTITIES:
                sizes[quantity].add(getattr(point, quantity).error)
        for name, largest in asdict(found.closure).items():
            self.closure[name] = max(self.closure[name], largest)
        self.phase.add(np.array([found.phase_max, found.phase_final]))
        self.drive["speed"] = max(self.drive["speed"], found.drive_speed)
        self.drive["acceleration"] = max(self.drive["acceleration"], found.drive_acceleration)

    def failed(self, trajectory: Trajectory) -> Measurement:
        """Of a run that did not complete, in the piece given."""
        return Measurement(trajectory.outcome.slug, trajectory.reason, extremes=self._extremes().as_dict())

    def completed(self) -> Measurement:
        """Of a run all of whose pieces completed."""
        return Measurement(
            outcome=Outcome.COMPLETED.slug,
            errors={p: {q: sizes.as_dict() for q, sizes in of.items()} for p, of in self.errors.items()},
            closure=self.closure,
            phase={"max": self.phase.largest, "final": self.phase.final},
            drive=self.drive,
            extremes=self._extremes().as_dict(),
        )

    def _extremes(self) -> Extremes:
        return Extremes(
            samples=self.samples,
            finite=self.finite,
            warnings=self.warnings,
            solver=None,
            torque=None,
            penetration=None,
            flights=(),
            history=(),
            fingerprint=self.digest.hexdigest(),
        )


def _recorded(trajectory: Trajectory) -> Iterator[Array]:
    assert trajectory.bodies is not None
    states = trajectory.bodies.position
    yield states.poses
    yield states.rates
    for tracks in trajectory.points.values():
        yield tracks.position.values
        yield tracks.velocity.values
        yield tracks.acceleration.values
