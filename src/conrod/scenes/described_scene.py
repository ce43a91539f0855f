"""Scenes described by mechanism files."""

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
from conrod.mechanism.files import MachineDescription, read_description, read_tables
from conrod.mechanism.mechanism import Mechanism
from conrod.mechanism.units import REVOLUTION, Parameter
from conrod.scenes.scene import Scene, canonical_json

MAX_START_DEVIATION = math.radians(60.0)  # rotation of a body from its given start; beyond it the branch is another
MIN_SINGULAR_VALUE = 1e-9  # of the scaled Jacobian; below it a link can move although the crank is held
POSE_DIGITS = 9  # decimals of a start pose [m, rad]
MIN_TRAVEL = 1e-6  # of a point, over the machine's size: errors over a shorter travel are 1e-10 by rounding alone
MAX_CACHED_SCENES = 128


@dataclass(frozen=True)
class DescribedScene(Scene):
    """A mechanism from a file, whose exact motion comes from the generic solver."""

    closed_form: ClassVar[bool] = False

    document: str = field(repr=False)  # the file's tables as canonical JSON
    given_anew: tuple[tuple[str, float], ...] = ()  # numbers of the file that have another value, SI, sorted by name
    nearby: DescribedScene | None = field(default=None, repr=False, compare=False)  # of a fit, with about its lengths
    speed: float = field(init=False, compare=False)

    def __post_init__(self) -> None:
        about = self.described
        for name in ("title", "source", "assumptions", "frame", "output", "speed"):
            object.__setattr__(self, name, getattr(about, name))
        object.__setattr__(self, "kind", about.name)
        super().__post_init__()
        # Reports fill in parameters at braces; those of a file's text are literal.
        object.__setattr__(
            self, "description", (about.about + self._change_point_sentence()).replace("{", "{{").replace("}", "}}")
        )

    def as_saved(self) -> dict[str, object]:
        return {"document": self.document, "given_anew": dict(self.given_anew)}

    def __reduce__(self) -> tuple[object, ...]:
        # Checks track a whole revolution: a process that unpickles a scene again need not repeat them.
        return _cached_scene, (type(self), self.document, self.given_anew)

    @cached_property
    def described(self) -> MachineDescription:
        """The parsed content of the file."""
        return read_description(json.loads(self.document), dict(self.given_anew))

    # -- facts ---------------------------------------------------------------------------------------------------

    def _change_point_sentence(self) -> str:
        """Sentence on change points for the description; empty for a linkage without them."""
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

    def disc_radii(self) -> dict[str, float]:
        tables = json.loads(self.document)["bodies"]
        discs = (body for body in self.mechanism().bodies if tables[body.name].get("uniform") == "disc")
        return {body.name: math.sqrt(2.0 * body.inertia / body.mass) for body in discs}  # I = m r^2 / 2

    def with_parameters(self, **values: float) -> Self:
        return type(self)(self.document, tuple(sorted((dict(self.given_anew) | values).items())))

    def with_nearby_parameters(self, **values: float) -> Self:
        return type(self)(self.document, tuple(sorted((dict(self.given_anew) | values).items())), self)

    @cached_property
    def kinematics(self) -> Kinematics:
        """The generic solver of this mechanism."""
        return Kinematics(self.mechanism(), None if self.nearby is None else self.nearby.kinematics)

    def identity(self) -> dict[str, Any]:
        """The mechanism and its speed as plain values, independent of names' order and of texts in the file."""
        mechanism = self.mechanism()
        kinds = [type(joint).__name__ for joint in mechanism.joints]
        # Start poses only pick the branch; they are computed, so their last digit may differ between processors.
        poses = {body: [round(value, POSE_DIGITS) for value in pose] for body, pose in mechanism.poses.items()}
        parts = asdict(mechanism) | {"poses": poses, "loads": [load.identity() for load in mechanism.loads]}
        if not mechanism.loads:
            del parts["loads"]  # keeps keys of runs from before loads existed
        # Rates do not affect motion at a prescribed angle; left out, they keep earlier keys too.
        rates = {"start_rates": dict(self.described.rates)} if self.described.rates else {}
        return {"mechanism": parts, "kinds": kinds, "speed": self.speed} | rates

    @property
    def start_rates(self) -> dict[str, float]:
        """Turn rates [rad/s] given in [start]; if none are, the crank's speed."""
        return dict(self.described.rates) or super().start_rates

    def mechanism(self) -> Mechanism:
        return self.described.mechanism

    def _angle_derivatives(self, angle: Array, side: Side) -> Mapping[str, PointDerivatives]:
        return self.kinematics.planar_derivatives(self.kinematics.derivatives(angle, side=side))

    # -- checks --------------------------------------------------------------------------------------------------

    def _checked_start(self) -> Array:
        """Exact poses at crank angle 0; refuses a start where the crank does not determine them."""
        start = np.array([self.mechanism().poses[body.name] for body in self.mechanism().bodies]).reshape(1, -1)
        try:
            start = self.kinematics.start
        except InvalidInput:
            # Newton iteration fails even from exact poses where links can move although the crank is held.
            if self.kinematics.conditioning(start)[0] >= MIN_SINGULAR_VALUE:
                raise
        if self.kinematics.conditioning(start)[0] < MIN_SINGULAR_VALUE:
            raise InvalidInput(
                f"{self.kind}: at crank angle 0 the crank does not determine the other bodies: a dead centre or a "
                "change point, or a part that moves by itself while another one is locked"
            )
        return start

    def _check_geometry(self) -> None:
        start = self._checked_start()
        check_meshes(self.mechanism(), start)
        for body, hint in self.described.hints.items():
            turn = start[0, 3 * self.mechanism().body_index[body] + 2]
            off = 0.0 if hint.turn is None else math.remainder(turn - hint.turn, REVOLUTION)
            if hint.turn is not None and abs(off) > MAX_START_DEVIATION:
                raise InvalidInput(
                    f"start.{body}.turn = {math.degrees(hint.turn):.6g} deg leads to an assembly where it is "
                    f"{math.degrees(hint.turn + off):.6g} deg: give it nearer to the one that is meant"
                )
        _check_reach(self.kinematics)
        if self.nearby is None:
            _check_travel(self.kinematics)


def _check_reach(kinematics: Kinematics) -> None:
    """Refuse an input that does not reach all crank angles of its turn, or of its pass.

    Raises:
        InvalidInput: gives the range that it reaches.
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
    """Refuse an observed point that does not move; InvalidInput names it."""
    for name, travel in kinematics.lengths.items():
        if travel < MIN_TRAVEL * kinematics.size:
            raise InvalidInput(
                f"observed.{name}: the point moves {travel:.3g} m in all, too little to normalise errors by: observe "
                f"points that move by a millionth of the machine's size, {kinematics.size:.3g} m, at least"
            )


@lru_cache(MAX_CACHED_SCENES)
def _cached_scene(
    scene_class: type[DescribedScene], document: str, given_anew: tuple[tuple[str, float], ...]
) -> DescribedScene:
    """Build a scene once for each document and values, so that a process checks it once."""
    return scene_class(document, given_anew)


def read_scene(path: Path) -> DescribedScene:
    """Read a scene from a file; InvalidInput names the file, the field and the expected content."""
    tables = read_tables(path)
    try:
        return scene_from_tables(tables)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from None


def scene_from_tables(tables: Mapping[str, Any]) -> DescribedScene:
    """Build a scene from the tables of a TOML text; InvalidInput names the field and the expected content."""
    # Parsed before it is written as JSON, so that values that JSON lacks (dates, nan) are refused with their place.
    read_description(tables, {})
    return DescribedScene(canonical_json(tables))
