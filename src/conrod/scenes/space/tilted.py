"""A planar slider-crank in a plane that stands at any angle in space, its loop closed with more than it takes."""

from __future__ import annotations

from conrod.exact.jet import direction, sine_cosine, square_root
from conrod.exact.motion import Array
from conrod.scenes.space.machine import Drives, SpatialMachine, SpatialMotion, start_pose
from conrod.scenes.space.model import Closure, Joint, Link
from conrod.scenes.space.vectors import DEGREE, X, Y, Z, rotated, unit

AXIS, ORIGIN = unit(X + 2.0 * Y - Z), 0.1 * (X - Y + 2.0 * Z)


def tilted_slider_crank(
    crank: float = 0.1, rod: float = 0.3, offset: float = 0.02, tilt: float = 50.0 * DEGREE, axis: Array = AXIS,
    origin: Array = ORIGIN,
) -> SpatialMachine:  # fmt: skip
    """Slide = crank cos(input) + sqrt(rod^2 - (crank sin(input) - offset)^2), along the slide's line.

    The rod is cut in the middle and welded: six equations where the plane leaves three.

    Args:
        crank, rod, offset: lengths [m], and the slide's distance from the shaft.
        tilt, axis: the plane is XY turned by an angle [rad] about a unit axis.
        origin: the shaft's place in the world [m].
    """
    along, across, shaft = (rotated(v, axis, tilt) for v in (X, Y, Z))

    def closed_form(drives: Drives) -> SpatialMotion:
        turn = drives["input"]
        sine, cosine = sine_cosine(turn)
        drop = offset - crank * sine
        reach = square_root(rod**2 - drop * drop)
        slide, slope = crank * cosine + reach, direction(reach, drop)
        crank_pin = crank * (cosine * along + sine * across) + origin
        slider = slide * along + (offset * across + origin)
        return SpatialMotion(
            points={"crank_pin": crank_pin, "slider": slider, "rod_middle": 0.5 * (crank_pin + slider)},
            joints={"input": turn, "rod": slope - turn, "output": slide, "wrist": slope},
        )

    at = start_pose(closed_form, ["input"])
    pin, slider, middle = at["crank_pin"], at["slider"], at["rod_middle"]
    rod_link = Link("rod", pin, (Joint("rod", shaft),), (middle,), {"rod_middle": middle})
    wrist_link = Link("rod_end", slider, (Joint("wrist", shaft),), (middle,))
    links = (
        Link("crank", origin, (Joint("input", shaft),), (pin,), {"crank_pin": pin}, (rod_link,)),
        Link("slider", slider, (Joint("output", along, "slide"),), (), {"slider": slider}, (wrist_link,)),
    )
    closures = [Closure("rod_weld", "rod", "rod_end", "weld")]
    source = "Uicker, Pennock, Shigley: Theory of Machines and Mechanisms, offset slider-crank"
    return SpatialMachine(
        "tilted-slider-crank", "Slider-crank turned in space", source, links, closures, {"input": "60rpm"}, closed_form,
        degrees_of_freedom=1, gruebler=-2,
    )  # fmt: skip
