"""Document 001, chapter 6: Examples 6.15 and 6.18. Units as in `module_velocities`, accelerations in m/s^2.

Numbers of a polygon are measured to a millimetre of the drawing: half of one, at the printed scale, is the reading.
"""

from __future__ import annotations

import math
from functools import cache

from audits.documents.module_linkages import SIX_BAR_SPEED, RackLinkage, SixBar, least_misfit
from audits.documents.module_velocities import CaseOf, caused, contradicted, plain, read_only, slipped
from audits.judging import Case, Explanation, Item

HALF_MM = 0.05  # [cm]
SPEED_SCALE, ACCELERATION_SCALE = 2.0, 75.0  # a cm, in Example 6.15; the printed 81 is a misprint
RACK_SPEED_SCALE, RACK_ACCELERATION_SCALE = 1.0, 50.0  # in Example 6.18
AB, AE, BE, CD, ARM_5 = 0.53, 0.53, 0.19, 0.45, 0.49
BX, CX, DX = 1.05, 1.21, 0.90
READINGS_OF_ACCELERATION = (255.0, 247.5, 97.5, 532.5, 225.0, 187.5, 727.5)


@cache
def six_bar() -> SixBar:
    """Example 6.15 at its printed instant."""
    return SixBar()


@cache
def pose() -> str:
    """The pose of Example 6.15 as far as it is known, in words."""
    return (
        f"no pose of the printed lengths gives the velocity polygon: the best of all misses a side by "
        f"{least_misfit():.2f} m/s; this value is of a pose fitted to it, so that agreement with it is partly circular"
    )


def _posed(item: Item, exact: float, reading: float, beside: tuple[Explanation, ...], more: str = "") -> Case:
    return Case(item, exact, pose() + more, roundings=beside, reading=reading, certain=False)


def _speed(point: str, other: str | None = None, *beside: Explanation, more: str = "") -> CaseOf:
    """A speed of the polygon; `beside` has what other readings of it make of this one."""
    return lambda item: _posed(item, six_bar().speed(point, other), HALF_MM * SPEED_SCALE, beside, more)


def _acceleration(point: str, *beside: Explanation) -> CaseOf:
    return lambda item: _posed(item, six_bar().acceleration(point), HALF_MM * ACCELERATION_SCALE, beside)


def _tangential(point: str, centre: str, *beside: Explanation) -> CaseOf:
    return lambda item: _posed(item, six_bar().tangential(point, centre), HALF_MM * ACCELERATION_SCALE, beside)


def _link_4(speed: float, text: str, arm: float, by: float) -> Explanation:
    """A relative speed of link 4 from another one, as it has one angular velocity; good to both readings."""
    return Explanation(f"{text}, link 4 having one angular velocity,", speed / by * arm,
                       HALF_MM * SPEED_SCALE * (1.0 + arm / by))  # fmt: skip


def _side(text: str, first: float, second: float, sign: int) -> Explanation:
    """A side of the right-angled triangle of an acceleration and its parts, the first one measured from the polygon."""
    value = math.sqrt(first**2 + sign * second**2)
    return Explanation(text, value, HALF_MM * ACCELERATION_SCALE * (1.0 + first / value))


def image(size_a: float, size_b: float, relative: float) -> tuple[float, float]:
    """Sizes of a vector of E by the image of the triangle ABE, for its two sides, the smaller first.

    Args:
        size_a, size_b, relative: sizes of the vectors of A, of B and of B against A.
    """
    between = math.acos((size_b**2 - size_a**2 - relative**2) / (2.0 * size_a * relative))
    corner = math.acos((AB**2 + AE**2 - BE**2) / (2.0 * AB * AE))
    arm = relative * AE / AB
    squares = [size_a**2 + arm**2 + 2.0 * size_a * arm * math.cos(between + s * corner) for s in (1, -1)]
    return math.sqrt(min(squares)), math.sqrt(max(squares))


def _image_acceleration(item: Item) -> Case:
    near, far = image(781.25, 255.0, math.hypot(727.5, 30.18))
    return Case(item, None, f"the image of ABE on the printed A_A, A_B and A_B/A gives {far:.1f} or {near:.1f} m/s^2")


def _scale(item: Item) -> Case:
    """The scale: all seven readings are then whole millimetres."""
    off = {
        scale: max(abs(value / scale * 10.0 - round(value / scale * 10.0)) for value in READINGS_OF_ACCELERATION)
        for scale in (ACCELERATION_SCALE, item.number.value)
    }
    why = (
        f"at {ACCELERATION_SCALE:g} the seven measured accelerations are whole millimetres to "
        f"{off[ACCELERATION_SCALE]:.2f} mm, at {item.number.text} not: {off[item.number.value]:.2f} mm"
    )
    return contradicted(None, why, "the seven accelerations beside it", ACCELERATION_SCALE)(item)


def _auxiliary(point: str) -> CaseOf:
    def case(item: Item) -> Case:
        bar = six_bar()
        place = bar.auxiliary - bar.places[point]
        return Case(item, math.hypot(*place), "geometry of link 4 from DB, BC, CD, BX4 and DX4")

    return case


def _rack_tangential(part: int) -> CaseOf:
    """The tangential acceleration of C (0) or of B against C (1), from the right and the printed normal one of B."""
    linkage, reading = RackLinkage(), HALF_MM * RACK_ACCELERATION_SCALE
    right, wrong = 6.0**2 / 0.3, 8.0**2 / 0.3
    velocity_reading = HALF_MM * RACK_SPEED_SCALE
    return slipped(
        linkage.tangential(right)[part],
        "acceleration polygon on V_B = 6, V_C = 6,9 and V_C/B = 5 m/s, normal A_B = 120 m/s^2",
        (
            "the polygon drawn with the wrong normal A_B = 213,33 m/s^2 (which makes the tangential A_C "
            f"{linkage.tangential(wrong)[0]:.0f}, where 320 is printed)"
        ),
        linkage.tangential(wrong)[part],
        within=reading + linkage.spread(wrong, part, velocity_reading),
        reading=reading + linkage.spread(right, part, velocity_reading),
    )


SLIDER = "a slider does not turn"
LOST = "read from a polygon whose drawing is lost; the triangle with 6 m/s closes, and nothing printed fixes its shape"

CASES: dict[str, CaseOf] = {
    "6.15-w2": plain(SIX_BAR_SPEED, "600 x 2 pi/60"),
    "6.15-va": plain(SIX_BAR_SPEED * 0.2, "omega 2 x O12A"),
    "6.15-cx": _auxiliary("C"),
    "6.15-vc": _speed("C"),
    "6.15-vd": _speed("D"),
    "6.15-vb": _speed("B"),
    "6.15-ve": plain(
        image(12.5, 12.2, 4.0)[1],
        "velocity image on the printed V_A, V_B, V_B/A, E on one side of AB; on the other it is 10,8 m/s, and "
        "which side the lost drawing had is not known",
    ),
    "6.15-vxc": _speed("X", "C", _link_4(18.8, "V_X4/D = 18,8 over DX4 times CX4", CX, DX)),
    "6.15-vxb": contradicted(
        None,
        "link 4 has one angular velocity, and 25,4/1,21 = 20,99 and 9,4/0,45 = 20,89 rad/s support it against 19,81",
        "V_X4/D = 18,8 over DX4 = 0,9 times BX4 = 1,05",
        18.8 / DX * BX,
        HALF_MM * SPEED_SCALE * (1.0 + BX / DX),
    ),
    "6.15-vxd": _speed("X", "D", _link_4(9.4, "V_D/C = 9,4 over CD times DX4", DX, CD)),
    "6.15-vba": _speed("B", "A"),
    "6.15-vx": _speed("X", more="; V_D = 6,4 and V_X4/D = 18,8, which are parallel, make 25,2 together"),
    "6.15-vdc": _speed("D", "C", _link_4(18.8, "V_X4/D = 18,8 over DX4 times CD", CD, DX)),
    "6.15-w3": plain(4.0 / AB, "V_B/A over AB"),
    "6.15-w5": plain(7.4 / ARM_5, "V_C over O15C"),
    "6.15-slider": plain(0.0, SLIDER),
    "6.15-aa": caused(
        SIX_BAR_SPEED**2 * 0.2, "omega 2^2 x O12A", "V_A cut to 12,5 m/s, squared over 0,2,", 12.5**2 / 0.2
    ),
    "6.15-nba": plain(4.0**2 / AB, "V_B/A^2 over AB"),
    "6.15-nc": plain(7.4**2 / ARM_5, "V_C^2 over O15C"),
    "6.15-put-vxc": contradicted(25.4, "V_X4/C of the velocity polygon", "V_X4/C = 25,4 of line 1256", 25.4, 0.05),
    "6.15-nxc": slipped(25.4**2 / CX, "V_X4/C^2 over CX4", "25,2 in place of 25,4 m/s", 25.2**2 / CX),
    "6.15-nxb": plain(20.8**2 / BX, "V_X4/B^2 over BX4"),
    "6.15-nxd": plain(18.8**2 / DX, "V_X4/D^2 over DX4"),
    "6.15-ncd": plain(9.4**2 / CD, "V_D/C^2 over CD"),
    "6.15-ab": _acceleration("B"),
    "6.15-ac": _acceleration("C", _side("the sum of its parts, 225 across and 111,75 along O15C,", 225.0, 111.75, 1)),
    "6.15-ad": _acceleration("D"),
    "6.15-ae": _image_acceleration,
    "6.15-tc": _tangential("C", "O15", _side("A_C = 247,5 less its part 111,75 along O15C", 247.5, 111.75, -1)),
    "6.15-tdc": _tangential("D", "C"),
    "6.15-tba": _tangential("B", "A"),
    "6.15-scale": _scale,
    "6.15-alpha3": plain(727.5 / AB, "A_B/A over AB"),
    "6.15-put-cd": contradicted(CD, "CD of line 1189", "187,5 over alpha 4 = 416,67", 187.5 / 416.67, 1e-4),
    "6.15-alpha4": plain(187.5 / CD, "A_D/C over CD"),
    "6.15-put-tc": contradicted(225.0, "A_C of line 1346", "A_C = 225 of line 1346", 225.0, 0.5),
    "6.15-alpha5": slipped(
        225.0 / ARM_5,
        "A_C over O15C (A_C = 247,5 and its part 111,75 along O15C leave 221 across, not 255)",
        "255 (A_B) in place of 225 m/s^2",
        255.0 / ARM_5,
    ),
    "6.2-crank": plain(0.0, "the crank's speed is constant"),
    "6.14-centre": plain(0.0, "the centre moves along a straight line"),
    "6.18-read": read_only(LOST),
    "6.18-w3": plain(5.0 / 0.25, "V_C/B over BC"),
    "6.18-w4": plain(6.0 / 0.3, "V_B over O14B"),
    "6.18-put-vb": contradicted(6.0, "the rack's speed", "6 m/s of the task and of omega 4 = 6/0,3 (line 1464)", 6.0),
    "6.18-nb": slipped(6.0**2 / 0.3, "V_B^2 over O14B", "8 in place of 6 m/s", 8.0**2 / 0.3),
    "6.18-nc": plain(6.9**2 / 0.13, "V_C^2 over O12C"),
    "6.18-nbc": plain(5.0**2 / 0.25, "V_B/C^2 over BC"),
    "6.18-tc": _rack_tangential(0),
    "6.18-tbc": _rack_tangential(1),
    "6.18-alpha2": plain(320.0 / 0.13, "A_C over O12C"),
    "6.18-alpha4": plain(0.0, "the rack's speed is constant"),
}
