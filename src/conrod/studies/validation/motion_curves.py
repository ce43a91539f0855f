"""Exact motion of a scene's output point over the last revolution of its runs, and its extremes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from conrod.exact.motion import QUANTITIES, Array, PointMotion
from conrod.mechanism.units import REVOLUTION
from conrod.report import numbers
from conrod.scenes import Scene
from conrod.studies.validation.results import SceneStudy, ValidationResult, drawable_runs

# Units of a page, and the factor from SI.
PAGE_UNITS = {"position": ("mm", 1e3), "velocity": ("m/s", 1.0), "acceleration": ("m/s²", 1.0), "jerk": ("m/s³", 1.0)}
COMPONENTS = "xy"
STEP = math.radians(0.25)  # between exact samples [rad]: a parabola through three finds an extreme to 0.01 deg
NOISE_SHARE = 1e-9  # of L, omega L, ...: what a component moves by less is rounding, as is a difference of extremes
STEP_NOISE = 1e-3  # of the noise: what a step may rise or fall by rounding
NOTHING_SHARE = 1e-6  # of the other extreme: a smaller one is printed as 0
VALUE_DIGITS, SETTLED_DIGITS = 4, 9  # of a printed value; and of the value before, which hides its last bits


@dataclass(frozen=True)
class ExactCurve:
    """A component of a quantity of the output point against the crank angle.

    Attributes:
        component: 0 for x, 1 for y.
        pieces: crank angles (K,) [rad] and values (K,) in the unit of a page, from break to break.
        noise: difference of values that is rounding.
    """

    component: int
    pieces: Sequence[tuple[Array, Array]]
    noise: float

    @cached_property
    def extremes(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Crank angle [rad] and value of the smallest and of the largest value; of equal ones the first."""
        return self._extreme(-1.0), self._extreme(1.0)

    def _extreme(self, sign: float) -> tuple[float, float]:
        """Return the angle and value of the largest `sign` x value, by a parabola through three samples."""
        found: list[tuple[float, float]] = []
        for angles, values in self.pieces:
            high = sign * values
            at = int(np.argmax(high > high.max() - self.noise))
            rounding = STEP_NOISE * self.noise
            while at < len(high) - 1 and high[at + 1] > high[at] + rounding:
                at += 1  # up a flat side, to its very top
            angle, value = float(angles[at]), float(high[at])
            dwells = at + 2 < len(high) and high[at + 1 : at + 3].min() > value - rounding
            inside = 0 < at < len(high) - 1 and not dwells
            if inside and (bend := float(high[at - 1] + high[at + 1]) - 2.0 * value) < 0.0:
                # Vertex of the parabola through (-1, left), (0, value), (1, right), in steps.
                rise = float(high[at + 1] - high[at - 1])
                shift = float(np.clip(-0.5 * rise / bend, -0.5, 0.5))
                angle += shift * float(angles[at + 1] - angles[at])
                value += (0.5 * rise + 0.5 * bend * shift) * shift
            found.append((angle, value))
        most = max(value for _, value in found)
        angle, value = next(one for one in found if one[1] > most - self.noise)
        return angle, sign * value

    def words(self, whole: float) -> str:
        """Return the extremes in words, with angles less the whole turns [rad] before."""
        nothing = NOTHING_SHARE * max(abs(value) for _, value in self.extremes)
        low, high = (
            f"{_value_text(value if abs(value) > nothing else 0.0)} at {_degrees_text(angle - whole)}"
            for angle, value in self.extremes
        )
        return f"from {low} to {high}"


def _value_text(value: float) -> str:
    return numbers.quantity(numbers.round_to_digits(value, SETTLED_DIGITS), VALUE_DIGITS)


def _degrees_text(angle: float) -> str:
    return f"{round(math.degrees(angle), 6):z.1f} deg"


@dataclass(frozen=True)
class DrawnTurn:
    """The last revolution of a study's runs, or its one pass.

    Attributes:
        scene: the machine.
        ends: crank angles [rad] at which it begins and ends, in the order of time.
        whole: angle of the whole turns before it [rad], which a figure leaves out.
    """

    scene: Scene
    ends: tuple[float, float]
    whole: float

    @classmethod
    def from_study(cls, study: SceneStudy) -> DrawnTurn:
        """Return the last revolution of the runs of a study; the first one without runs."""
        scene = study.scene
        if scene.kinematics.mechanism.driver.span is not None:
            low, high = scene.kinematics.span
            return cls(scene, (low, high) if scene.speed > 0.0 else (high, low), 0.0)
        turns = max((run.revolutions for run in drawable_runs(study.results)), default=1.0)
        sense = math.copysign(REVOLUTION, scene.speed)
        first = sense * (turns - 1.0)
        return cls(scene, (first, first + sense), sense * math.floor(turns - 1.0))

    @property
    def printed_ends(self) -> tuple[float, float]:
        """Ends of the drawn turn without the whole turns before it [deg]."""
        first, last = (math.degrees(end - self.whole) for end in self.ends)
        return first, last

    @cached_property
    def curves(self) -> dict[str, list[ExactCurve]]:
        """The exact curves of the components that move, by quantity; with a cam also of the jerk."""
        scene, output = self.scene, self.scene.output
        pieces = [(angles, self._exact(angles)) for angles in self._smooth_pieces()]
        positions = np.concatenate([motion.position for _, motion in pieces])
        length = scene.lengths[output]
        both = range(len(COMPONENTS))
        moving = [k for k in both if np.ptp(positions[:, k]) > NOISE_SHARE * length] or both
        found = {}
        for order, quantity in enumerate((*QUANTITIES, "jerk")[: None if self._has_cam else -1]):
            factor = PAGE_UNITS[quantity][1]
            noise = factor * NOISE_SHARE * length * abs(scene.speed) ** order
            found[quantity] = [
                ExactCurve(k, [(at, factor * getattr(motion, quantity)[:, k]) for at, motion in pieces], noise)
                for k in moving
            ]
        return found

    @property
    def _has_cam(self) -> bool:
        return bool(self.scene.kinematics.mechanism.cam_contacts)

    def _smooth_pieces(self) -> list[Array]:
        """Return evenly spaced crank angles [rad] from each break to the next, ascending."""
        low, high = sorted(self.ends)
        turns = np.arange(math.floor(low / REVOLUTION), math.ceil(high / REVOLUTION) + 1)
        breaks = np.add.outer(REVOLUTION * turns, np.array(self.scene.break_angles())).ravel()
        inside = breaks[(breaks > low + STEP) & (breaks < high - STEP)]
        edges = [low, *np.sort(inside).tolist(), high]
        return [np.linspace(a, b, math.ceil((b - a) / STEP) + 1) for a, b in pairwise(edges)]

    def _exact(self, angles: Array) -> PointMotion:
        """Return the exact motion of the output point on a piece, with the limits from within at its ends."""
        scene = self.scene
        right = scene.motion(angles[:-1], scene.speed).point(scene.output)
        left = scene.motion(angles[-1:], scene.speed, side="left").point(scene.output)
        return PointMotion(*(np.concatenate([getattr(side, name) for side in (right, left)]) for name in PAGE_UNITS))


def marked_runs(study: SceneStudy) -> list[ValidationResult]:
    """Return the runs whose samples are saved, to be marked in the figure of motion."""
    return [run for run in drawable_runs(study.results) if run.samples]


def motion_words(study: SceneStudy) -> str:
    """Return the text alternative of the figure of motion, with all extremes."""
    turn = DrawnTurn.from_study(study)
    found = [
        f"{quantity} [{PAGE_UNITS[quantity][0]}] "
        + ", ".join(f"{COMPONENTS[curve.component]} {curve.words(turn.whole)}" for curve in curves)
        for quantity, curves in turn.curves.items()
    ]
    return f"Motion of {study.scene.output} of {study.name} against the crank angle: {'; '.join(found)}"
