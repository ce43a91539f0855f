"""Compare the links of a model with those of a planar machine, whether the model can move or not.

A model that cannot turn has no paths to be known by. Its links are compared instead: both machines are graphs of links,
joined by pins and slides. One graph is laid over the other, crank on crank, and the distances on each are compared.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import combinations, islice, product

import numpy as np

from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Mechanism, Prismatic, Revolute
from conrod.mjcf.request import LENGTH_UNITS
from conrod.report.numbers import unequal_quantities

NUMBER_TOLERANCE = 1e-6  # of the machine's size: numbers of a file with six digits
MAX_MATCHES = 2000  # ways of laying one graph over the other that are looked at


@dataclass(frozen=True)
class LinkDifference:
    """A distance on a link that differs from the machine's [m]."""

    link: str
    ends: tuple[str, str]
    found: float
    expected: float

    @property
    def words(self) -> str:
        """'coupler is 42.3 % shorter from pin a to pin b: 150 mm instead of 260 mm'."""
        one, other = self.ends
        if self.expected == 0.0:
            return f"{self.link} has {one} {1e3 * self.found:.6g} mm from {other}, where they should be at one place"
        sizes = "{} mm instead of {} mm".format(*unequal_quantities(1e3 * self.found, 1e3 * self.expected, 6))
        share = self.found / self.expected - 1.0
        way = "longer" if share > 0.0 else "shorter"
        return f"{self.link} is {100.0 * abs(share):.3g} % {way} from {one} to {other}: {sizes}"


@dataclass(frozen=True)
class SlideTilt:
    """A slide whose angle to the pins of its link differs from the machine's [rad]."""

    slide: str
    link: str
    angle: float

    @property
    def words(self) -> str:
        """'slide is tilted by 0.5 deg on ground'."""
        return f"{self.slide} is tilted by {np.degrees(self.angle):.3g} deg on {self.link}"


@dataclass
class PlanarLink:
    """A rigid link with its pins, points and slides in planar coordinates.

    Attributes:
        pins, points: places (2,) of its pins and observed points, by name.
        lines: a point (2,) and the direction (2,) of each slide.
    """

    pins: dict[str, Array] = field(default_factory=dict)
    points: dict[str, Array] = field(default_factory=dict)
    lines: dict[str, tuple[Array, Array]] = field(default_factory=dict)


@dataclass(frozen=True)
class PlanarJoint:
    """A pin or a slide between two links."""

    name: str
    kind: str
    links: tuple[str, str]


@dataclass
class LinkGraph:
    """Links by name, and the joints between them."""

    crank: str
    links: dict[str, PlanarLink] = field(default_factory=dict)
    edges: list[PlanarJoint] = field(default_factory=list)

    def link(self, name: str) -> PlanarLink:
        """The link of a name; a new one is added."""
        return self.links.setdefault(name, PlanarLink())

    def pin(self, name: str, one: str, other: str, places: tuple[Array, Array]) -> None:
        """Join two links by a pin at its place (2,) on each."""
        self.edges.append(PlanarJoint(name, "pin", (one, other)))
        self.link(one).pins[name], self.link(other).pins[name] = places

    def slide(self, name: str, one: str, other: str, lines: tuple[tuple[Array, Array], tuple[Array, Array]]) -> None:
        """Join two links by a slide along its line on each."""
        self.edges.append(PlanarJoint(name, "slide", (one, other)))
        self.link(one).lines[name], self.link(other).lines[name] = lines


def graph_of(mechanism: Mechanism) -> LinkGraph | None:
    """Build the link graph of a planar machine of pins and slides; None if it has other joints."""
    made = LinkGraph(mechanism.crank)
    for joint in mechanism.joints:
        match joint:
            case Revolute():
                made.pin(joint.name, joint.a, joint.b, (np.array(joint.point_a), np.array(joint.point_b)))
            case Prismatic():
                ways = [np.array([np.cos(a), np.sin(a)]) for a in (joint.direction, joint.direction - joint.angle)]
                lines = (np.array(joint.point_a), ways[0]), (np.array(joint.point_b), ways[1])
                made.slide(joint.name, joint.a, joint.b, lines)
            case _:
                return None
    for one in mechanism.observed:
        made.link(one.body).points[one.name] = np.array(one.point)
    return made


# -- one laid over the other -------------------------------------------------------------------------------------------


def link_differences(model: LinkGraph, machine: LinkGraph) -> tuple[LinkDifference | SlideTilt, ...] | None:
    """Tilts and distances on the model's links that differ from the machine's; None if the links do not match.

    Of several ways of laying the model over the machine the one with the fewest differences counts. The model's unit of
    length is the one in which most distances are the machine's.
    """
    found = [
        _differences_of(model, machine, match, unit)
        for match in islice(_graph_matches(model, machine), MAX_MATCHES)
        for unit in LENGTH_UNITS.values()
    ]
    best = min(found, key=lambda some: (len(some[0]), sum(map(_log_ratio, some[0]))), default=None)
    if best is None:
        return None
    distances, tilts = best
    # A point at a pin has the pin's distances.
    alike = {(one.link, f"{one.found:.9g}", f"{one.expected:.9g}"): one for one in reversed(distances)}
    return *tilts, *sorted(alike.values(), key=_log_ratio, reverse=True)


def _log_ratio(one: LinkDifference) -> float:
    """Absolute logarithm of the ratio of a found to an expected distance."""
    return abs(float(np.log(max(one.found, 1e-12) / max(one.expected, 1e-12))))


Match = tuple[Mapping[str, str], Mapping[str, str]]  # links and joints of the machine to those of the model


def _graph_matches(model: LinkGraph, machine: LinkGraph) -> Iterator[Match]:
    """Match the machine's joints to the model's one by one, so that links and points correspond."""
    if len(model.edges) != len(machine.edges) or len(model.links) != len(machine.links):
        return
    order = _order_outwards(machine)

    def extend_match(at: int, links: dict[str, str], joints: dict[str, str]) -> Iterator[Match]:
        """Match the joint number `at` and all after it, given the links and joints matched so far."""
        if at == len(order):
            yield links, joints
            return
        edge = order[at]
        for other in model.edges:
            if other.kind != edge.kind or other.name in joints.values():
                continue
            for ends in (other.links, other.links[::-1]):
                more = _match_ends(links, edge.links, ends)
                if more is not None and _carries_points(model, machine, more):
                    yield from extend_match(at + 1, more, {**joints, edge.name: other.name})

    yield from extend_match(0, {GROUND: GROUND, machine.crank: model.crank}, {})


def _match_ends(links: Mapping[str, str], ends: tuple[str, str], others: tuple[str, str]) -> dict[str, str] | None:
    """Extend a matching of links by the two ends of a joint; None if that contradicts the matching."""
    made = dict(links)
    for end, other in zip(ends, others, strict=True):
        if made.get(end, other) != other or (end not in made and other in made.values()):
            return None
        made[end] = other
    return made


def _carries_points(model: LinkGraph, machine: LinkGraph, links: Mapping[str, str]) -> bool:
    """True if each observed point is on matching links."""
    place = {point: name for name, link in model.links.items() for point in link.points}
    return all(place.get(p, on) == on for name, on in links.items() for p in machine.links[name].points)


def _order_outwards(machine: LinkGraph) -> list[PlanarJoint]:
    """Order joints outwards from ground and crank, each connected to an earlier one where possible."""
    known, left, order = {GROUND, machine.crank}, list(machine.edges), list[PlanarJoint]()
    while left:
        edge = next((edge for edge in left if known & {*edge.links}), left[0])
        left.remove(edge)
        known |= {*edge.links}
        order.append(edge)
    return order


def _differences_of(
    model: LinkGraph, machine: LinkGraph, match: Match, unit: float
) -> tuple[list[LinkDifference], list[SlideTilt]]:
    """Differences of a model under one matching and one unit of length."""
    links, joints = match
    names = {theirs: mine for mine, theirs in joints.items()}
    own = LinkGraph(machine.crank)
    for name, theirs in links.items():
        own.links[name] = _rename_joints(model.links[theirs], names)
    own.edges = machine.edges
    expected, found = dict(_distances(machine)), dict(_distances(own))
    size = max(expected.values(), default=1.0)
    distances = [
        LinkDifference(link, (one, other), unit * found[link, one, other], right)
        for (link, one, other), right in expected.items()
        if (link, one, other) in found and abs(unit * found[link, one, other] - right) > NUMBER_TOLERANCE * size
    ]
    angles, own_angles = dict(_angles(machine)), dict(_angles(own))
    off = {place: abs(own_angles.get(place, angle) - angle) for place, angle in angles.items()}
    return distances, [SlideTilt(*place, angle) for place, angle in off.items() if angle > NUMBER_TOLERANCE]


def _rename_joints(link: PlanarLink, names: Mapping[str, str]) -> PlanarLink:
    """A model's link with the machine's names of its joints."""
    pins = {names[name]: place for name, place in link.pins.items()}
    return PlanarLink(pins, link.points, {names[name]: line for name, line in link.lines.items()})


def _distances(graph: LinkGraph) -> Iterator[tuple[tuple[str, str, str], float]]:
    """Distances between pins and points of each link, and between pins on both sides of a slide, across it.

    A pin p moves along the slide at a distance s(p) from the line on its own link; seen from the other link that is a
    parallel line, from which a pin q is |s(q) - s(p)| away. Which line the slide is drawn on does not matter then.
    """
    for name, link in graph.links.items():
        places = [*((f"pin {pin}", place) for pin, place in sorted(link.pins.items())), *sorted(link.points.items())]
        for (one, first), (other, second) in combinations(places, 2):
            yield (name, one, other), float(np.linalg.norm(first - second))
    for edge in (edge for edge in graph.edges if edge.kind == "slide"):
        sides = [_line_distances(graph.links[name], edge.name) for name in edge.links]
        for (one, near), (other, far) in product(sides[0].items(), sides[1].items()):
            yield (edge.name, f"pin {one}", f"the line of pin {other}"), abs(near - far)


def _angles(graph: LinkGraph) -> Iterator[tuple[tuple[str, str], float]]:
    """Angle [rad], from 0 to 90 deg, between each slide's line and its link's two pins furthest apart."""
    for link, one in sorted(graph.links.items()):
        ways = [b - a for (_, a), (_, b) in combinations(sorted(one.pins.items()), 2)]
        if ways and np.linalg.norm(way := max(ways, key=lambda way: float(np.linalg.norm(way)))) > 0.0:
            for slide, (_, line) in sorted(one.lines.items()):
                across = way[0] * line[1] - way[1] * line[0]
                yield (slide, link), float(np.arctan2(abs(across), abs(way @ line)))


def _line_distances(link: PlanarLink, slide: str) -> dict[str, float]:
    """Signed distance of each pin of a link from the line of one of its slides."""
    start, way = link.lines[slide]
    return {name: float(way[0] * (p - start)[1] - way[1] * (p - start)[0]) for name, p in sorted(link.pins.items())}
