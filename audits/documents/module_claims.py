"""Claims of document 001 about its machines, held against their exact motion."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from audits.documents.module_linkages import SixBar
from audits.pin_instant import size, turned
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.models.printed.verdicts import PrintedVerdict, VerdictKind
from conrod.scenes import catalogue_scene

TWO_SLIDERS = "two-slider-linkage"  # Example 4.10 in the catalogue
COINCIDENT = "inverted-slider-crank"  # Figure 5.5
SAME = 1e-9


def verdicts() -> Iterator[PrintedVerdict]:
    """One on each claim."""
    yield _sense(750, "omega 3", "A", "B", -1)
    yield _sense(760, "omega 5", "B", "C", 1)
    yield _one_turn()
    yield _auxiliary_line()


def turn_of(name: str, first: str, second: str) -> float:
    """Angular velocity [rad/s] of the link through two points of a catalogue's machine at its crank angle 0."""
    scene = catalogue_scene(name)
    points = scene.motion([0.0], scene.speed).points
    arm = points[second].position[0] - points[first].position[0]
    going = points[second].velocity[0] - points[first].velocity[0]
    return float(going @ turned(arm)) / size(arm) ** 2


def _sense(line: int, quantity: str, first: str, second: str, printed: int) -> PrintedVerdict:
    """The sense in which a link of Example 4.10 turns: 1 counter-clockwise, -1 clockwise."""
    turn = turn_of(TWO_SLIDERS, first, second)
    text = {1: "berlawanan arah jarum jam (counter-clockwise)", -1: "searah jarum jam (clockwise)"}
    reason = f"{turn:.2f} rad/s, counter-clockwise positive, in the catalogue's {TWO_SLIDERS}"
    right = "" if printed * turn > 0.0 else text[-printed]
    return _verdict("Example 4.10", line, f"sense of {quantity}", text[printed], reason, right, VerdictKind.MISPRINT)


def _one_turn() -> PrintedVerdict:
    """A block that slides along a link turns with it, at every crank angle."""
    mechanism = catalogue_scene(COINCIDENT).mechanism()
    rates = Kinematics(mechanism).derivatives(np.radians(np.arange(0.0, 360.0, 7.0)), 1)[1].reshape(52, -1, 3)[:, :, 2]
    block, link = (mechanism.body_index[name] for name in ("block", "link"))
    apart = float(np.abs(rates[:, block] - rates[:, link]).max())
    return _verdict("section 5.5", 877, "omega 3 and omega 4", "the same size and sense",
                    f"at 52 crank angles of the catalogue's {COINCIDENT} they differ by less than {SAME:g} of omega 2",
                    "" if apart < SAME else "they differ", VerdictKind.WRONG_STEP)  # fmt: skip


def second_auxiliary() -> Array:
    """Y4 [m] of Example 6.15, (2,), in the frame of link 4: where the lines O15C and AB meet."""
    places = SixBar().places
    along, arm = places["A"] - places["B"], places["C"] - places["O15"]
    far = np.linalg.solve(np.column_stack([along, -arm]), places["C"] - places["B"])
    return np.asarray(places["B"] + far[0] * along)


def _auxiliary_line() -> PrintedVerdict:
    """Lines 1370 and 1380: Y4 is to move in the direction of C, which it does on the line O15C alone."""
    bar = SixBar()
    going = bar.velocities["C"]
    rod = bar.places["D"] - bar.places["C"]
    turn = float((bar.velocities["D"] - going) @ turned(rod)) / size(rod) ** 2

    def off(along: Array) -> float:
        """Angle [deg] between V_C and the velocity of the point of link 4 at C + along."""
        velocity = going + turn * turned(along)
        across = abs(float(velocity @ turned(going))) / (size(velocity) * size(going))
        return math.degrees(math.asin(min(across, 1.0)))

    reach = second_auxiliary() - bar.places["C"]
    wrong = off(turned(reach))
    right = "" if wrong < SAME else "in line with link 5, at right angles to V_C"
    reason = (
        f"with V_Y4/C at right angles to CY4, V_Y4 is parallel to V_C where CY4 is: on the line O15C it is off by "
        f"{off(reach):.1f} deg, at right angles to it by {wrong:.0f} deg at that distance"
    )
    return _verdict("section 6.8", 1380, "direction of CY4", "at right angles to link 5, so that V_Y4 // V_C", reason,
                    right, VerdictKind.MISPRINT)  # fmt: skip


def _verdict(
    place: str, line: int, quantity: str, text: str, reason: str, right: str, kind: VerdictKind
) -> PrintedVerdict:
    """A claim that holds unless something else is right."""
    found = (kind, reason, right) if right else (VerdictKind.AGREES, reason, None)
    return PrintedVerdict("001", place, line, quantity, "statement", "", text, None, None, *found)
