"""A validated machine in motion: exact poses, errors of runs with poses, and its drawing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.drawing.drawing import telling_angle
from conrod.report.html.parts import DRAWING_UNITS, MachineDrawing, drawing_of, svg_number
from conrod.studies.validation.results import SceneStudy, ValidationResult

POSES = 360  # exact poses of a turn
VISIBLE_SHARE = 0.06  # of the machine's extent: greatest size of a magnified error
MAX_POWER = 12
FRAMES = 48  # poses of an animation of a turn
SECONDS = 6.0  # of an animation of a turn
TILE_SIZE = (
    160.0,
    105.0,
)  # px of a picture among others, where its words take 10 px; the style of the picture alone is left out there
STYLE = """svg{--ink:#222;--faint:#777;--part:#dde6ec;--ground:#fff;--raised:#f2f2f2}.ghost{color:#8a949e;opacity:.4}
.engine{color:#2673b8}text{font-family:sans-serif}@media(prefers-color-scheme:dark){svg{--ink:#e4e8ec;--faint:#a3adb8;--part:#2c3944;--ground:#14181c;
--raised:#1e242a}.engine{color:#79b8f2}}"""


@dataclass(frozen=True)
class MovingMachine:
    """A machine in motion, exact and as some runs have it.

    Attributes:
        study: validation of the machine.
        runs: runs with errors of poses, at least one.
    """

    study: SceneStudy
    runs: tuple[ValidationResult, ...]

    @cached_property
    def drawing(self) -> MachineDrawing:
        """Shapes of the bodies, as SVG."""
        return drawing_of(self.study.scene)

    @cached_property
    def angles(self) -> Array:
        """Crank angles (`POSES` + 1,) [rad] of the exact poses, over the last turn of the runs."""
        first = self.runs[0].poses
        assert first is not None
        return np.linspace(first.angle[0], first.angle[-1], POSES + 1)

    @property
    def ends(self) -> tuple[float, float]:
        """First and last crank angle as printed [deg]: full turns before are subtracted."""
        whole = 0.0 if self.study.scene.kinematics.mechanism.driver.span else 2.0 * math.pi
        first = self.angles[0] - (round(self.angles[0] / whole) * whole if whole else 0.0)
        return math.degrees(first), math.degrees(first + self.angles[-1] - self.angles[0])

    @property
    def still(self) -> int:
        """Number of the pose at which the machine is drawn where nothing moves."""
        first, last = np.radians(self.ends)
        return int(np.clip(round((telling_angle(self.study.scene) - first) / (last - first) * POSES), 0, POSES))

    @cached_property
    def exact(self) -> Array:
        """Exact poses (`POSES` + 1, 3 n) in drawing units."""
        return self.drawing.poses(self.study.scene.kinematics.poses(self.angles))

    def errors(self, run: ValidationResult) -> Array:
        """Return errors (K, 3 n) of a run's poses in drawing units, at K equally spaced angles."""
        assert run.poses is not None
        return self.drawing.poses(run.poses.values)

    def power(self, run: ValidationResult) -> int:
        """Return the power of ten by which to magnify a run's error to make it visible."""
        errors = np.abs(self.errors(run)).reshape(-1, 3) * [1.0, 1.0, math.radians(DRAWING_UNITS / 4.0)]
        largest = float(errors.max())
        return (
            int(np.clip(math.floor(math.log10(VISIBLE_SHARE * DRAWING_UNITS / largest)), 0, MAX_POWER))
            if largest
            else 0
        )


def moving_machine(study: SceneStudy) -> MovingMachine | None:
    """Return a study's machine in motion; None if no run has poses."""
    runs = tuple(run for run in study.results if run.poses is not None and len(run.poses.angle) > 1)
    return MovingMachine(study, runs) if runs else None


def transforms(poses: Array) -> list[str]:
    """Return the SVG transform of each body from its pose in drawing units."""
    return [
        f"translate({svg_number(x, 3)} {svg_number(y, 3)}) rotate({svg_number(turn, 4)})"
        for x, y, turn in poses.reshape(-1, 3)
    ]


# -- an animated SVG ---------------------------------------------------------------------------------------------------


def animated_svg(machine: MovingMachine) -> str:
    """Draw the first run over the exact machine as an animated SVG, with its error magnified."""
    run, bodies = machine.runs[0], list(machine.drawing.bodies.values())
    exact, errors = machine.exact[:: POSES // FRAMES], machine.errors(run)
    rows = np.round(np.linspace(0, len(errors) - 1, len(exact))).astype(int)
    engine = exact + 10.0 ** machine.power(run) * errors[rows]
    still = round(machine.still * FRAMES / POSES)
    shapes = "".join(f'<g id="b{k}">{body}</g>' for k, body in enumerate(bodies[:-1]))
    order = machine.drawing.order
    looks = {"ghost": _animated_bodies(exact, still, order), "engine": _animated_bodies(engine, still, order)}
    moved = "".join(f'<g class="{name}">{found}</g>\n' for name, found in looks.items())
    left, top, width, height = machine.drawing.box
    small = 10.0 * max(width / TILE_SIZE[0], height / TILE_SIZE[1])
    height += 1.5 * small
    note = (
        f'<text x="{left + width / 2:.0f}" y="{top + height - 0.4 * small:.0f}" text-anchor="middle" '
        f'font-size="{small:.0f}" fill="var(--ink)">{_note(machine)}</text>'
    )
    style = f"{STYLE}text{{font-size:{20.0 * width / 640.0:.0f}px}}"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{left:.0f} {top:.0f} {width:.0f} {height:.0f}" width="640" '
        f'height="{640 * height / width:.0f}"><style>{style}</style><defs>{shapes}</defs>\n'
        f"{bodies[-1]}\n{moved}{note}</svg>\n"
    )


def _note(machine: MovingMachine) -> str:
    """Say how far off the drawn run is, and how much larger it is drawn."""
    run, lengths = machine.runs[0], machine.study.scene.lengths
    errors = {point: (sizes["position"] or {}).get("max") for point, sizes in (run.errors or {}).items()}
    power = machine.power(run)
    drawn = f", drawn x {numbers.power_of_ten(power)}" if power else ""
    return f"{numbers.in_mm(errors, lengths)} mm off{drawn}".replace("<", "&lt;")


def _animated_bodies(poses: Array, still: int, order: Sequence[int]) -> str:
    """Return the bodies, animated through their poses.

    Args:
        poses: (K, 3 n), in drawing units.
        still: number of the pose to show where nothing moves.
        order: numbers of the bodies, the first one drawn at the bottom."""
    found = ""
    for k in order:
        body = poses[:, 3 * k : 3 * k + 3]
        places = ";".join(f"{svg_number(x)} {svg_number(y)}" for x, y, _ in body)
        turns = ";".join(svg_number(turn, 2) for *_, turn in body)
        x, y, turn = svg_number(body[still][0]), svg_number(body[still][1]), svg_number(body[still][2], 2)
        found += (
            f'<g transform="translate({x} {y})">{_animation("translate", places)}'
            f'<g transform="rotate({turn})">{_animation("rotate", turns)}<use href="#b{k}"/></g></g>'
        )
    return found


def _animation(kind: str, values: str) -> str:
    """Return the SVG element that animates a transform through its values, without end."""
    return (
        f'<animateTransform attributeName="transform" type="{kind}" values="{values}" dur="{SECONDS:.0f}s" '
        'repeatCount="indefinite"/>'
    )
