"""Request for a user's model, and what is read of it, as plain data that need no engine.

Lengths are in the model's own unit and frame, which are not known yet. Coordinates of the crank are those of its hinge
[rad], positive about the hinge's axis. P points, T angles of a turn, K samples of a run.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Real
from typing import TypeAlias

from conrod.errors import InvalidInput, as_mapping, unknown_choice
from conrod.exact.motion import Array

KINDS = ("site", "body", "geom")
# A start that is open by a thousandth of the machine is not the machine's: what soft closures leave of a pose that was
# simulated is less. By a hundredth of that it is said: numbers of six digits leave a tenth of it.
OPEN_START, AJAR = 1e-3, 1e-5


@dataclass(frozen=True)
class Place:
    """Position of an observed point in a model.

    Attributes:
        point: name of the observed point.
        kind: site, body or geom.
    """

    point: str
    kind: str
    element: str

    def __str__(self) -> str:
        return f"{self.kind}:{self.element}"


def places_of(places: Mapping[str, str], observed: Sequence[str] = ()) -> tuple[Place, ...]:
    """Places in a model of observed points, each given as "body:slider"; a name without a kind is a site's.

    Args:
        observed: names that points may have; any where there are none.

    Raises:
        InvalidInput: a point is unknown, or a kind of element.
    """
    found = list[Place]()
    for name, where in as_mapping("points", places, "{'C': 'site:tip'}").items():
        if observed and name not in observed:
            raise unknown_choice("observed point", name, observed)
        kind, colon, element = where.partition(":")
        if colon and not element and kind not in KINDS:
            raise unknown_choice("kind of element", kind, KINDS)
        # A name may have a colon in it itself.
        found.append(Place(name, kind, element) if colon and kind in KINDS else Place(name, KINDS[0], where))
    return tuple(found)


# Control inputs by an actuator's name or number, in MuJoCo's own units.
Controls: TypeAlias = tuple[tuple[str, float], ...]
CONTROL_FORM = "an actuator and a finite number in MuJoCo's units: motor=4.19"


def controls_of(controls: Mapping[str, float]) -> Controls:
    """Control inputs by an actuator's name or number, all of which are finite.

    Raises:
        InvalidInput: a value is no finite number.
    """
    given = as_mapping("controls", controls, "{'motor': 4.19}")
    for name, value in given.items():
        if not isinstance(value, Real) or not math.isfinite(value):
            raise InvalidInput(f"--ctrl '{name}={value}': give {CONTROL_FORM}")
    return tuple((name, float(value)) for name, value in given.items())


@dataclass(frozen=True)
class Question:
    """A model's points and crank, and the machine that it is to be.

    Attributes:
        crank: name of the hinge that is driven.
        mobility: that the machine has, contacts counted.
        contacts: number of higher pairs of the machine, which a model may close by contact.
        keyframe: to assemble the model from; None for its reference pose.
        controls: inputs of actuators in place of the keyframe's, where the model is run as its file has it.
        span: crank angles [rad] between which the machine makes its one pass; None where it turns fully; by the study.
        returns: whether all observed points of the machine are back after a turn; by the study.
    """

    crank: str
    places: tuple[Place, ...]
    mobility: int
    contacts: int
    keyframe: str | None = None
    controls: Controls = ()
    span: tuple[float, float] | None = None
    returns: bool = True

    @property
    def width(self) -> float:
        """Angle [rad] that the crank is to go through: of the pass, or a turn."""
        return 2.0 * math.pi if self.span is None else self.span[1] - self.span[0]


# -- what is read of it ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class StartRates:
    """Rates in which a file's own run starts, against those that its loops ask for.

    Attributes:
        opening: largest rate at which they open a closure, in the model's unit of length [/s].
        joint: whose rate is furthest from what the loops ask for, with the crank's rate as it is.
        found, asked: its rates [rad/s, or the model's unit of length /s].
        unit: rad/s, or m/s of a slide.
    """

    opening: float
    joint: str
    found: float
    asked: float
    unit: str


@dataclass(frozen=True)
class OpenStart:
    """Loops that are open in the pose in which a file's own run starts.

    Attributes:
        pose: in words, such as 'its own pose'.
        gaps: opening of each closure that is open, by name, in the model's unit of length.
        extent: of the machine, in the same unit.
        closed: the nearest closed pose as `qpos` of MJCF; empty where no pose near it closes the loops.
    """

    pose: str
    gaps: Mapping[str, float]
    extent: float
    closed: str

    @property
    def worst(self) -> str:
        """The closure that is furthest open."""
        return max(self.gaps, key=lambda name: self.gaps[name])

    def exceeds(self, allowed: float | None) -> bool:
        """True if it is open by more than is allowed, in the model's unit; None for `OPEN_START` of its extent."""
        return self.gaps[self.worst] > (OPEN_START * self.extent if allowed is None else allowed)


@dataclass(frozen=True)
class ModelFacts:
    """A model by the account of its compiled file and of one turn of its crank.

    Attributes:
        joints: number of joints by kind: hinge, slide, ball, free.
        closures: number of active equality constraints by kind: connect, weld, joint, tendon, ...
        coordinates: degrees of freedom that the joints give.
        rank: of the closures' Jacobian.
        touching: names of the two geoms that make a higher pair; None where closures place everything.
        settings: that it comes with, in words.
        stops: joints whose limits the turn leaves, with both.
        start: of a run of the file as it is, in words.
        controls: inputs of all actuators in that run, by name or number.
        begins: where that run begins with its loops open; None where they are closed.
        about: closures that are inactive, handles, or hold parts that do not meet, in words.
        from_keyframe: whether that run starts from a keyframe, which is what a file says of its start.
        moves: whether it starts with a rate that is not 0.
        rates: where they open the loops; None where they do not, or the loops are open anyway.
        rigid: observed points that are rigid with the crank, which no closure can move.
    """

    name: str
    engine_version: str
    joints: Mapping[str, int]
    closures: Mapping[str, int]
    coordinates: int
    rank: int
    touching: tuple[str, str] | None
    timestep: float  # [s]
    settings: str
    stops: tuple[str, ...] = ()
    start: str = ""
    controls: Mapping[str, float] = field(default_factory=dict)
    begins: OpenStart | None = None
    about: str = ""
    from_keyframe: bool = False
    moves: bool = False
    rates: StartRates | None = None
    rigid: tuple[str, ...] = ()


@dataclass(frozen=True)
class Scan:
    """One turn of a model with its crank held at T angles; of an input that makes one pass all that it can go.

    Attributes:
        coordinate: of the crank (T,), from the start of the turn upwards, evenly spaced.
        points: names of the P points that were given.
        positions: of the points (P, T, 3).
        turns: of the links that the points are on, about the crank's axis, from the first sample on (P, T) [rad].
        anchor, axis: of the crank's hinge, a point and a unit vector.
        wander: how far anchor and axis move in a turn.
        shape_error: depth of a mesh's facets under its curve, where a contact places the points.
    """

    facts: ModelFacts
    coordinate: Array
    points: tuple[str, ...]
    positions: Array
    turns: Array
    anchor: Array
    axis: Array
    wander: float
    shape_error: float
