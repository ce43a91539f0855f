"""The request for the check of a user's model, and what is read from the model, as plain data that need no engine.

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
from conrod.report.numbers import quantity

ELEMENT_KINDS = ("site", "body", "geom")
# A start that is open by a thousandth of the machine is not the machine's: what soft closures leave of a pose that was
# simulated is less. By a hundredth of that it is said: numbers of six digits leave a tenth of it.
MAX_START_OPENING, MIN_NAMED_OPENING = 1e-3, 1e-5
MAX_POSE_NUMBERS = 20  # coordinates of a pose in a sentence


@dataclass(frozen=True)
class PointPlace:
    """Where an observed point is in a model: a site, body or geom.

    Attributes:
        point: name of the observed point.
        kind: site, body or geom.
    """

    point: str
    kind: str
    element: str

    def __str__(self) -> str:
        return f"{self.kind}:{self.element}"


def places_of(places: Mapping[str, str], observed: Sequence[str] = ()) -> tuple[PointPlace, ...]:
    """Parse places of observed points, each as "body:slider"; a name without a kind is a site's.

    Args:
        observed: names that points may have; any where there are none.

    Raises:
        InvalidInput: a point is unknown, or a kind of element.
    """
    found = list[PointPlace]()
    for name, where in as_mapping("points", places, "{'C': 'site:tip'}").items():
        if observed and name not in observed:
            raise unknown_choice("observed point", name, observed)
        kind, colon, element = where.partition(":")
        if colon and not element and kind not in ELEMENT_KINDS:
            raise unknown_choice("kind of element", kind, ELEMENT_KINDS)
        # A name may have a colon in it itself.
        found.append(
            PointPlace(name, kind, element)
            if colon and kind in ELEMENT_KINDS
            else PointPlace(name, ELEMENT_KINDS[0], where)
        )
    return tuple(found)


# Units of length that a model may be in: their size [m].
LENGTH_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "inch": 0.0254}


def size_of_unit(unit: str | None) -> float:
    """Size [m] of a model's unit of length; of the metre where none is given.

    Raises:
        InvalidInput: no such unit; names the units.
    """
    if unit is None:
        return 1.0
    if unit not in LENGTH_UNITS:
        raise unknown_choice("unit of a model's lengths", unit, LENGTH_UNITS)
    return LENGTH_UNITS[unit]


# Control inputs by an actuator's name or number, in MuJoCo's own units.
Controls: TypeAlias = tuple[tuple[str, float], ...]
CONTROL_FORM = "an actuator and a finite number in MuJoCo's units: motor=4.19"


def controls_of(controls: Mapping[str, float]) -> Controls:
    """Check control inputs by an actuator's name or number: every value must be finite.

    Raises:
        InvalidInput: a value is no finite number.
    """
    given = as_mapping("controls", controls, "{'motor': 4.19}")
    for name, value in given.items():
        if not isinstance(value, Real) or not math.isfinite(value):
            raise InvalidInput(f"--ctrl '{name}={value}': give {CONTROL_FORM}")
    return tuple((name, float(value)) for name, value in given.items())


@dataclass(frozen=True)
class ModelRequest:
    """A user's request for a model: its points and crank, and the machine to compare with.

    Attributes:
        crank: name of the hinge that is driven.
        mobility: mobility of the machine with its contacts.
        contacts: number of higher pairs of the machine, which a model may close by contact.
        keyframe: keyframe to assemble the model from; None for its reference pose.
        controls: inputs of actuators in place of the keyframe's, where the model is run as its file has it.
        span: crank angles [rad] between which the machine makes its one pass; None where it turns fully; by the study.
        returns: whether all observed points of the machine are back after a turn; by the study.
        unit: unit of the file's lengths [m], in place of which metres are used from its loading on.
        taken: crank and points that were found and not given, in words.
    """

    crank: str
    places: tuple[PointPlace, ...]
    mobility: int
    contacts: int
    keyframe: str | None = None
    controls: Controls = ()
    span: tuple[float, float] | None = None
    returns: bool = True
    unit: float = 1.0
    taken: str = ""

    @property
    def width(self) -> float:
        """Angle [rad] that the crank travels: the pass, or a turn."""
        return 2.0 * math.pi if self.span is None else self.span[1] - self.span[0]


# -- what is read of it ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class StartRates:
    """Joint rates at the start of a file's own run that violate its closures.

    Attributes:
        opening: largest rate at which they open a closure, in the model's unit of length [/s].
        joint: joint whose rate differs most from the rate that the loops require at the crank's given rate.
        found, asked: rate of this joint, and the required rate [rad/s, or the model's unit of length /s].
        unit: rad/s, or m/s of a slide.
    """

    opening: float
    joint: str
    found: float
    asked: float
    unit: str


@dataclass(frozen=True)
class OpenStart:
    """Closures that are open at the start of a file's own run.

    Attributes:
        pose: the pose in words, such as 'its own pose'.
        gaps: opening of each closure that is open, by name, in the model's unit of length.
        extent: size of the machine, in the same unit.
        closed: the nearest closed pose as `qpos` of MJCF; empty where no pose near it closes the loops.
    """

    pose: str
    gaps: Mapping[str, float]
    extent: float
    closed: str

    @property
    def worst(self) -> str:
        """Name of the closure with the largest opening."""
        return max(self.gaps, key=lambda name: self.gaps[name])

    def exceeds(self, allowed: float | None) -> bool:
        """True if a closure is open by more than allowed, in the model's unit; None allows `MAX_START_OPENING`."""
        return self.gaps[self.worst] > (MAX_START_OPENING * self.extent if allowed is None else allowed)

    def words(self, unit: float = 1.0) -> str:
        """Say how far the loops are open at the start, and where they would be closed.

        Args:
            unit: unit of the model's lengths [m].
        """
        worst, more = self.worst, len(self.gaps) - 1
        others = f" ({more} more closure{'s' if more > 1 else ''} open)" if more else ""
        gap = f"{quantity(1e3 * unit * self.gaps[worst], 3)} mm"
        if not self.closed:
            nearest = "no pose near it closes them: look at lengths and places of the closures"
        elif len(self.closed.split()) > MAX_POSE_NUMBERS:
            nearest = "`conrod lint` prints the nearest closed pose"
        else:
            nearest = f'the nearest closed pose is qpos="{self.closed}"'
        return f"It begins {gap} open: {worst}, in {self.pose}{others}; {nearest}."


@dataclass(frozen=True)
class ModelFacts:
    """Facts of a compiled model and of one turn of its crank.

    Attributes:
        joints: number of joints by kind: hinge, slide, ball, free.
        closures: number of active equality constraints by kind: connect, weld, joint, tendon, ...
        coordinates: degrees of freedom that the joints give.
        rank: rank of the closures' Jacobian.
        touching: names of the two geoms that make a higher pair; None where closures place everything.
        settings: the model's own settings, in words.
        stops: joints whose limits the turn leaves, with both.
        start: start of the file's own run, in words.
        controls: inputs of all actuators in that run, by name or number.
        begins: open start of that run; None if its loops start closed.
        about: closures that are inactive, handles, or hold parts that do not meet, in words.
        from_keyframe: whether that run starts from a keyframe, which is what a file says of its start.
        moves: whether it starts with a rate that is not 0.
        rates: start rates that open the loops; None if they do not, or if the loops are open anyway.
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
    """One turn of a model with its crank held at T angles; for a one-pass input all that the crank can travel.

    Attributes:
        coordinate: coordinate (T,) of the crank, evenly spaced upwards from the start of the turn.
        points: names of the P points that were given.
        positions: positions (P, T, 3) of the points.
        turns: rotation (P, T) [rad] of the points' links about the crank's axis since the first sample.
        anchor, axis: a point on the axis of the crank's hinge, and its unit vector.
        wander: largest displacement of anchor and axis in a turn.
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
