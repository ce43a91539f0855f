"""The slider-crank that pymunk's timings are told against.

NEVER CHANGE IT: ratios of any date and machine relate to this very space. Ten iterations, pymunk's defaults, a driven
crank of 0.1 m, a rod of 0.3 m and a slider in a groove; no gravity, no shapes.
"""

from __future__ import annotations

import math

import pymunk

from conrod.engines.pymunk.bare import BareRun


def reference_loop() -> BareRun:
    """The slider-crank at its start: in line, the crank at one turn a second, 1000 steps a turn."""
    space = pymunk.Space()
    space.iterations = 10
    speed = 6.283185307179586
    crank = pymunk.Body(body_type=pymunk.Body.KINEMATIC)
    crank.angular_velocity = speed
    rod = pymunk.Body(1.5, 0.01125)
    rod.position, rod.velocity, rod.angular_velocity = (0.25, 0.0), (0.0, 0.05 * speed), -speed / 3.0
    slider = pymunk.Body(6.0, math.inf)
    slider.position = (0.4, 0.0)
    space.add(crank, rod, slider)
    space.add(
        pymunk.PivotJoint(crank, rod, (0.1, 0.0), (-0.15, 0.0)),
        pymunk.PivotJoint(rod, slider, (0.15, 0.0), (0.0, 0.0)),
        pymunk.GrooveJoint(space.static_body, slider, (-10.0, 0.0), (10.0, 0.0), (0.0, 0.0)),
    )
    return BareRun(space, crank, (), timestep=0.001, turn=0.0, spin=speed)
