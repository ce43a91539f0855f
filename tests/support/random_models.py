"""Random spatial models with closed loops: trees of hinges, slides and balls, closed in each of MuJoCo's ways.

The seed chooses the kind in turn (`KINDS`), so that any run of seeds has all of them, and everything else at random:
frames, axes and anchors that point anywhere, several joints on a body, reference values, bodies that branch.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field

import mujoco
import numpy as np

from conrod.exact.motion import Array

KINDS = (
    "ring",  # one loop with one to three freedoms, and nothing beside it
    "ring",
    "branching",  # a loop with branches that hang from it
    "many loops",
    "coupled",  # by a polynomial of joints, or a fixed tendon, beside a loop
    "planar",  # a four-bar in a plane at any angle: of six rows or three, two or three say something
    "twice",  # a loop closed twice
    "locked",  # no freedom left
    "open",  # in the reference pose, by millimetres; it may close nearby
    "apart",  # by metres: no pose closes it
    "floating",  # a free base, with loops in what it carries
)
GAPS = {"open": (1e-3, 1e-2), "apart": (40.0, 60.0)}  # [m], of a closure's two ends in the reference pose


@dataclass
class _Body:
    element: ET.Element
    parent: _Body | None  # None for the world
    position: Array  # in the world, in the reference pose
    rotation: Array  # quaternion, the same
    joints: list[tuple[str, str]] = field(default_factory=list)  # (name, kind)

    @property
    def path(self) -> list[_Body]:
        return [self, *(self.parent.path if self.parent else [])]

    @property
    def freedoms(self) -> int:
        return sum({"hinge": 1, "slide": 1, "ball": 3, "free": 6}[kind] for _, kind in self.joints)


@dataclass(frozen=True)
class RandomModel:
    """A model, and what is known of it by construction."""

    seed: int
    kind: str  # of KINDS
    mjcf: str
    gap: float  # [m] between the ends of its first closure in the reference pose; 0 if it is assembled


def random_loop_model(seed: int) -> str:
    """MJCF of a random model with closed loops; every joint has a name."""
    return random_model(seed).mjcf


def random_model(seed: int) -> RandomModel:
    return _Builder(seed).model()


class _Builder:
    def __init__(self, seed: int) -> None:
        self.seed, self.kind, self.rng = seed, KINDS[seed % len(KINDS)], np.random.default_rng(seed)
        self.root = ET.Element("mujoco", model=f"random_{seed}")
        ET.SubElement(self.root, "compiler", angle="radian")
        world = ET.SubElement(self.root, "worldbody")
        self.tendon, self.equality = ET.Element("tendon"), ET.Element("equality")
        self.bodies = [_Body(world, None, np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))]
        self.closures = 0

    def model(self) -> RandomModel:
        low, high = GAPS.get(self.kind, (0.0, 0.0))
        gap = float(self.rng.uniform(low, high))
        if self.kind == "planar":
            self._planar()
        elif self.kind == "ring":
            self._ring()
        else:
            self._tree()
            self._close(self._ends(), gap)
        if self.kind == "many loops":
            self._close(self._ends())
            self._close(self._ends())
        if self.kind == "coupled":
            self._couple()
        if self.kind == "twice":
            self._repeat()
        self.root.extend(part for part in (self.tendon, self.equality) if len(part))
        ET.indent(self.root)
        return RandomModel(self.seed, self.kind, ET.tostring(self.root, encoding="unicode"), gap)

    # -- tree ----------------------------------------------------------------------------------------------------------

    def _tree(self) -> None:
        """Two or three branches that the first body or the world carries; few joints where it is to be locked."""
        count = {"locked": 2, "many loops": 10}.get(self.kind, int(self.rng.integers(4, 8)))
        for number in range(count):
            recent = self.bodies[-1]
            parent = recent if number and self.rng.random() < 0.7 else self.bodies[number and int(self.rng.integers(2))]
            self._body(parent, self._joint_kinds(number))

    def _joint_kinds(self, number: int) -> tuple[str, ...]:
        if self.kind == "locked":
            return ("hinge",)
        if self.kind == "floating" and number == 0:
            return ("free",)
        return self._some_joints(6)

    def _some_joints(self, most: int) -> tuple[str, ...]:
        """Joints of a body with at most so many freedoms. What is to be apart has no slide that could reach so far."""
        kinds = [("hinge",), ("hinge", "hinge"), ("ball",), ("slide",), ("slide", "hinge")]
        shares = np.array([0.55, 0.1, 0.12, 0.15, 0.08]) * [1, most > 1, most > 2, 1, most > 1]
        shares[3:] *= self.kind != "apart"
        return kinds[self.rng.choice(len(kinds), p=shares / shares.sum())]

    def _ring(self) -> None:
        """Two chains from the world, or one, closed at their tips."""
        kind, rows = [("connect", 3), ("weld", 6)][int(self.rng.random() < 0.4)]
        left, tips = rows + int(self.rng.integers(1, 4)), [self.bodies[0], self.bodies[0]]
        while left:
            side = int(self.rng.random() < 0.4)
            tips[side] = self._body(tips[side], self._some_joints(left))
            left -= tips[side].freedoms
        first, second = tips if tips[0].parent else tips[::-1]
        self._pin(first, second, first.position + self.rng.uniform(-0.2, 0.2, 3), 0.0, kind)

    def _body(
        self, parent: _Body, kinds: tuple[str, ...], axis: Array | None = None, offset: Array | None = None
    ) -> _Body:
        offset = self.rng.uniform(-0.3, 0.3, 3) if offset is None else offset
        turn = self._quaternion() if axis is None else np.array([1.0, 0.0, 0.0, 0.0])
        name = f"body_{len(self.bodies)}"
        element = ET.SubElement(parent.element, "body", name=name, pos=_text(offset), quat=_text(turn))
        position, rotation = np.empty(3), np.empty(4)
        mujoco.mju_rotVecQuat(position, offset, parent.rotation)
        mujoco.mju_mulQuat(rotation, parent.rotation, turn)
        body = _Body(element, parent, parent.position + position, rotation)
        for index, kind in enumerate(kinds):
            joint = f"{kind}_{len(self.bodies)}" + ("ab"[index] if len(kinds) > 1 else "")
            given = {"name": joint, "type": kind}
            if kind in ("hinge", "slide"):
                given |= {"axis": _text(self.rng.normal(size=3) if axis is None else axis)}
                given |= {"ref": _text([self.rng.uniform(-1.0, 1.0)])} if self.rng.random() < 0.2 else {}
            if kind != "free" and axis is None and self.rng.random() < 0.3:
                given |= {"pos": _text(self.rng.uniform(-0.05, 0.05, 3))}
            ET.SubElement(element, "joint", given)
            body.joints.append((joint, kind))
        ET.SubElement(element, "geom", size="0.02", contype="0", conaffinity="0")
        self.bodies.append(body)
        return body

    def _planar(self) -> None:
        """Crank, rod and rocker with parallel axes on a body that stands at any angle; the rocker's pin is closed."""
        stand = self._body(self.bodies[0], ())
        z = np.array([0.0, 0.0, 1.0])
        crank = self._body(stand, ("hinge",), z, np.zeros(3))
        rod = self._body(crank, ("hinge",), z, np.array([0.1, 0.05, 0.0]))
        rocker = self._body(stand, ("hinge",), z, np.array([0.4, 0.0, 0.0]))
        point = self._world(stand, np.array([0.35, 0.3, self.rng.uniform(-0.1, 0.1)]))
        self._pin(rod, rocker, point, 0.0, "connect")
        if self.rng.random() < 0.5:  # a second point of the same pin
            self._pin(rod, rocker, point + self._world(stand, 0.05 * z) - stand.position, 0.0, "connect")

    # -- closures ------------------------------------------------------------------------------------------------------

    def _ends(self) -> tuple[_Body, _Body]:
        """Two bodies with a loop between them, of more freedoms than a connect takes unless it is to be locked."""
        carried = self.bodies[1:] if self.kind == "floating" else self.bodies
        pairs = [(a, b) for a in carried for b in carried if a is not b and self._loop(a, b) > 0]
        long = [pair for pair in pairs if self._loop(*pair) > 3]
        if self.kind == "locked" or not long:
            return max(pairs, key=lambda pair: self._loop(*pair))
        return long[self.rng.integers(len(long))]

    def _loop(self, a: _Body, b: _Body) -> int:
        """Freedoms of the joints on the way from one body to the other."""
        on_one = [body for body in (*a.path, *b.path) if (body in a.path) != (body in b.path)]
        return sum(body.freedoms for body in on_one)

    def _close(self, ends: tuple[_Body, _Body], gap: float = 0.0) -> None:
        kind = "weld" if self._loop(*ends) > 6 and self.rng.random() < 0.5 else "connect"
        middle = 0.5 * (ends[0].position + ends[1].position) + self.rng.uniform(-0.1, 0.1, 3)
        self._pin(*ends, middle, gap, kind)

    def _pin(self, a: _Body, b: _Body, point: Array, gap: float, kind: str) -> None:
        """Closes the loop at a point of the world, by sites or by bodies; only sites can be open."""
        self.closures += 1
        name = f"{kind}_{self.closures}"
        if gap == 0.0 and self.rng.random() < 0.4:
            names = {f"body{k}": body.element.get("name") for k, body in enumerate((a, b), 1) if body.parent}
            # The world is the second body where none is given, and never the first.
            names = names if len(names) == 2 else {"body1": next(iter(names.values()))}
            first = a if a.parent else b
            anchor = {"anchor": _text(self._local(first, point))} if kind == "connect" else {}
            ET.SubElement(self.equality, kind, {"name": name, **names, **anchor})
            return
        turn = self._quaternion()
        away = gap * _unit(self.rng.normal(size=3))
        for end, body, place in (("a", a, point), ("b", b, point + away)):
            site = np.empty(4)
            mujoco.mju_mulQuat(site, _inverse(body.rotation), turn)
            pose = {"pos": _text(self._local(body, place)), "quat": _text(site)}
            ET.SubElement(body.element, "site", {"name": f"{name}_{end}", **pose})
        ET.SubElement(self.equality, kind, name=name, site1=f"{name}_a", site2=f"{name}_b")

    def _couple(self) -> None:
        joints = [name for body in self.bodies for name, kind in body.joints if kind in ("hinge", "slide")]
        first, second = self.rng.choice(joints, 2, replace=False)
        ratio = float(self.rng.uniform(-2.0, 2.0))
        if self.rng.random() < 0.5:
            polynomial = _text([0.0, ratio, 0.3 * ratio, 0.0, 0.0])
            ET.SubElement(self.equality, "joint", name="coupling", joint1=first, joint2=second, polycoef=polynomial)
        else:
            fixed = ET.SubElement(self.tendon, "fixed", name="cable")
            ET.SubElement(fixed, "joint", joint=first, coef="1")
            ET.SubElement(fixed, "joint", joint=second, coef=repr(ratio))
            ET.SubElement(self.equality, "tendon", name="coupling", tendon1="cable")

    def _repeat(self) -> None:
        again = ET.SubElement(self.equality, self.equality[0].tag, dict(self.equality[0].attrib))
        again.set("name", "once_more")

    # -- geometry ------------------------------------------------------------------------------------------------------

    def _quaternion(self) -> Array:
        return _unit(self.rng.normal(size=4))

    def _world(self, body: _Body, point: Array) -> Array:
        placed = np.empty(3)
        mujoco.mju_rotVecQuat(placed, point, body.rotation)
        return body.position + placed

    def _local(self, body: _Body, point: Array) -> Array:
        place = np.empty(3)
        mujoco.mju_rotVecQuat(place, point - body.position, _inverse(body.rotation))
        return place


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)


def _inverse(quaternion: Array) -> Array:
    return quaternion * [1.0, -1.0, -1.0, -1.0]


def _text(values: Array | list[float]) -> str:
    return " ".join(repr(float(value)) for value in values)
