"""A scene that a file describes."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np

from conrod.errors import InvalidInput, Named
from conrod.exact.branch_tracking import TooManyStepsError
from conrod.exact.equations import check_meshes
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, PointDerivatives, Side
from conrod.mechanism.files import Description, read_description, read_tables
from conrod.mechanism.mechanism import Mechanism
from conrod.mechanism.units import REVOLUTION, Parameter
from conrod.scenes.scene import Scene, canonical

# A body that Newton iteration turns by more than this from its given start has gone to another assembly.
STRAYED = math.radians(60.0)
# Smallest singular value of the scaled equations: below it, something moves though the crank is held.
SINGULAR = 1e-9
POSE_DIGITS = 9  # of a start pose [m, rad]
# Errors are measured over the travel of a point: over less than this part of the size, rounding alone is 1e-10.
LEAST_TRAVEL = 1e-6
SCENES_KEPT = 128  # of those that came from another process


@dataclass(frozen=True)
class DescribedScene(Scene):
    """A mechanism from a file, whose exact motion comes from the generic solver."""

    closed_form: ClassVar[bool] = False

    document: str = field(repr=False)  # the file's tables as canonical JSON
    given_anew: tuple[tuple[str, float], ...] = ()  # numbers of the file that have another value, SI, sorted by name
    speed: float = field(init=False, compare=False)

    def __post_init__(self) -> None:
        about = self.described
        for name in ("title", "source", "assumptions", "frame", "output", "speed"):
            object.__setattr__(self, name, getattr(about, name))
        object.__setattr__(self, "kind", about.name)
        super().__post_init__()
        # Reports fill parameters in where braces stand; a file has none to fill in.
        object.__setattr__(self, "description", (about.about + self._changes()).replace("{", "{{").replace("}", "}}"))

    def as_saved(self) -> dict[str, object]:
        return {"document": self.document, "given_anew": dict(self.given_anew)}

    def __reduce__(self) -> tuple[object, ...]:
        # The checks walk a mechanism around its turn: a process that meets a scene again has made them already.
        return _met, (type(self), self.document, self.given_anew)

    @cached_property
    def described(self) -> Description:
        """The content of the file."""
        return read_description(json.loads(self.document), dict(self.given_anew))

    # -- facts ---------------------------------------------------------------------------------------------------

    def _changes(self) -> str:
        """Words on change points; empty where there are none."""
        angles = [f"{angle:.6g}" for angle in np.degrees(self.kinematics.change_angles)]
        listed = " and ".join([", ".join(angles[:-1]), angles[-1]] if angles[1:] else angles)
        if not angles:
            return ""
        return (
            f" Change points: at crank angles of {listed} deg the linkage could go on in another assembly as well; the "
            "exact motion is the smooth continuation."
        )

    @cached_property
    def parameters(self) -> dict[str, float]:
        return Named(self.described.values, "parameter")

    def parameter_facts(self) -> dict[str, Parameter]:
        return dict(self.described.facts)

    def with_parameters(self, **values: float) -> Self:
        return type(self)(self.document, tuple(sorted((dict(self.given_anew) | values).items())))

    def identity(self) -> dict[str, Any]:
        """The mechanism and its speed, whatever a file calls things or in which order; not its texts."""
        mechanism = self.mechanism()
        kinds = [type(joint).__name__ for joint in mechanism.joints]
        # Start poses pick the assembly, and are worked out: their last digit may differ between machines.
        poses = {body: [round(value, POSE_DIGITS) for value in pose] for body, pose in mechanism.poses.items()}
        parts = asdict(mechanism) | {"poses": poses, "loads": [load.identity() for load in mechanism.loads]}
        if not mechanism.loads:
            del parts["loads"]  # as it was known before there were any
        # The exact motion at a prescribed angle has nothing of it, and was known without it.
        rates = {"start_rates": dict(self.described.rates)} if self.described.rates else {}
        return {"mechanism": parts, "kinds": kinds, "speed": self.speed} | rates

    @property
    def start_rates(self) -> dict[str, float]:
        """Those that the file gives in [start]; where it gives none, the crank's at its speed."""
        return dict(self.described.rates) or super().start_rates

    def mechanism(self) -> Mechanism:
        return self.described.mechanism

    def _angle_derivatives(self, angle: Array, side: Side) -> Mapping[str, PointDerivatives]:
        return self.kinematics.planar_derivatives(self.kinematics.derivatives(angle, side=side))

    # -- checks --------------------------------------------------------------------------------------------------

    def _start(self) -> Array:
        """Exact poses at crank angle 0; refuses a start where the crank does not determine them."""
        start = np.array([self.mechanism().poses[body.name] for body in self.mechanism().bodies]).reshape(1, -1)
        try:
            start = self.kinematics.start
        except InvalidInput:
            # No iteration settles where links can move though the crank is held, not even from poses that fit.
            if self.kinematics.conditioning(start)[0] >= SINGULAR:
                raise
        if self.kinematics.conditioning(start)[0] < SINGULAR:
            raise InvalidInput(
                f"{self.kind}: at crank angle 0 the crank does not determine the other bodies: a dead centre or a "
                "change point, or a part that moves by itself while another one is locked"
            )
        return start

    def _check_geometry(self) -> None:
        start = self._start()
        check_meshes(self.mechanism(), start)
        for body, hint in self.described.hints.items():
            turn = start[0, 3 * self.mechanism().body_index[body] + 2]
            off = 0.0 if hint.turn is None else math.remainder(turn - hint.turn, REVOLUTION)
            if hint.turn is not None and abs(off) > STRAYED:
                raise InvalidInput(
                    f"start.{body}.turn = {math.degrees(hint.turn):.6g} deg leads to an assembly where it is "
                    f"{math.degrees(hint.turn + off):.6g} deg: give it nearer to the one that is meant"
                )
        _check_reach(self.kinematics)
        _check_travel(self.kinematics)


def _check_reach(kinematics: Kinematics) -> None:
    """Refuse an input that does not reach all crank angles of its turn, or of its pass.

    Raises:
        InvalidInput: says how far it reaches.
    """
    span = kinematics.mechanism.driver.span
    if span is None and kinematics.turns_fully:
        return
    if span is not None:
        try:
            kinematics.poses(np.array(span))
            return
        except InvalidInput as error:
            if isinstance(error, TooManyStepsError):
                raise
    turn = REVOLUTION
    low, high = (math.degrees(kinematics.reachable_angle(goal)) for goal in (-turn, turn))
    wanted = "turn fully"
    if span is not None:
        wanted = f"pass from {math.degrees(span[0]):.6g} to {math.degrees(span[1]):.6g} deg"
    raise InvalidInput(
        f"driver: the crank cannot {wanted}: from its start it reaches {low:.2f} to {high:.2f} deg on this assembly; "
        "give driver.from and driver.to within that, for one pass"
    )


def _check_travel(kinematics: Kinematics) -> None:
    """Refuse an observed point that stands still; raises InvalidInput, which names it."""
    for name, travel in kinematics.lengths.items():
        if travel < LEAST_TRAVEL * kinematics.size:
            raise InvalidInput(
                f"observed.{name}: the point moves {travel:.3g} m in all, too little to normalise errors by: observe "
                f"points that move by a millionth of the machine's size, {kinematics.size:.3g} m, at least"
            )


@lru_cache(SCENES_KEPT)
def _met(scene_class: type[DescribedScene], document: str, given_anew: tuple[tuple[str, float], ...]) -> DescribedScene:
    return scene_class(document, given_anew)


def read_scene(path: Path) -> DescribedScene:
    """The scene that a file describes; raises InvalidInput, which names the file, the field and what was expected."""
    tables = read_tables(path)
    try:
        return scene_of(tables)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None


def scene_of(tables: Mapping[str, Any]) -> DescribedScene:
    """The scene of tables that a TOML text gave; raises InvalidInput, which names the field and what was expected."""
    # Read before it is written as JSON: what JSON does not know (dates, numbers that are none) is refused by its place.
    read_description(tables, {})
    return DescribedScene(canonical(tables))
