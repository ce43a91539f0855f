"""A validated machine with the runs whose bodies are known over a turn: exact poses, errors, and how it is drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from conrod.exact.motion import Array
from conrod.report.drawing.drawing import telling_angle
from conrod.report.html.parts import UNITS, Drawing, drawing_of
from conrod.studies.validation.results import SceneStudy, ValidationResult

POSES = 360  # exact poses of a turn, between which nothing can be seen
VISIBLE = 0.06  # of the machine: what an error is magnified to, at most
MOST_POWER = 12


@dataclass(frozen=True)
class Moving:
    """A machine with the runs whose bodies are known over a turn, and how it is drawn.

    Attributes:
        runs: that have errors of poses, one at least.
    """

    study: SceneStudy
    runs: tuple[ValidationResult, ...]

    @cached_property
    def drawing(self) -> Drawing:
        """Shapes of the bodies."""
        return drawing_of(self.study.scene)

    @cached_property
    def angles(self) -> Array:
        """Crank angles of the exact poses (`POSES` + 1,) [rad], over the stretch that the runs' last turn is."""
        first = self.runs[0].poses
        assert first is not None
        return np.linspace(first.angle[0], first.angle[-1], POSES + 1)

    @property
    def ends(self) -> tuple[float, float]:
        """The stretch as it is shown [deg]: a turn begins within the first."""
        whole = 0.0 if self.study.scene.kinematics.mechanism.driver.span else 2.0 * math.pi
        first = self.angles[0] - (round(self.angles[0] / whole) * whole if whole else 0.0)
        return math.degrees(first), math.degrees(first + self.angles[-1] - self.angles[0])

    @property
    def still(self) -> int:
        """Number of the pose at the angle that the machine is drawn at where nothing moves."""
        first, last = np.radians(self.ends)
        return int(np.clip(round((telling_angle(self.study.scene) - first) / (last - first) * POSES), 0, POSES))

    @cached_property
    def exact(self) -> Array:
        """Exact poses (`POSES` + 1, 3 n) of the drawing."""
        return self.drawing.poses(self.study.scene.kinematics.poses(self.angles))

    def errors(self, run: ValidationResult) -> Array:
        """Errors of a run's poses (K, 3 n) in the drawing, K evenly over the stretch."""
        assert run.poses is not None
        return self.drawing.poses(run.poses.values)

    def power(self, run: ValidationResult) -> int:
        """Power of ten that makes a run's error visible."""
        errors = np.abs(self.errors(run)).reshape(-1, 3) * [1.0, 1.0, math.radians(UNITS / 4.0)]
        largest = float(errors.max())
        return int(np.clip(math.floor(math.log10(VISIBLE * UNITS / largest)), 0, MOST_POWER)) if largest else 0


def moving(study: SceneStudy) -> Moving | None:
    """The machine in motion; None where no run came to its end, or an earlier conrod kept no poses."""
    runs = tuple(run for run in study.results if run.poses is not None and len(run.poses.angle) > 1)
    return Moving(study, runs) if runs else None


def transforms(poses: Array) -> list[str]:
    """Attributes that put each body in its place, from its pose in the drawing."""
    return [f"translate({x:.3f} {y:.3f}) rotate({turn:.4f})" for x, y, turn in poses.reshape(-1, 3)]
