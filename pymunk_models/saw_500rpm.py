"""Power hacksaw (offset slider-crank), scene saw-500rpm of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('C')

Source: document 002 (kinematic simulation of a power hacksaw by complex numbers), section 3.

Parameters (SI):

    crank = 0.1 m                             crank, shaft to crank pin
    rod = 0.3 m                               connecting rod, crank pin to slider
    offset = 0.09 m                           height of the slide above the shaft
    speed = 52.3598776 rad/s                  crank speed; negative is the other sense of rotation
    crank_mass = 4 kg                         crank disc, balanced about the shaft
    crank_inertia = 0.02 kg m²                crank disc, about the shaft
    rod_mass = 1.5 kg                         connecting rod, centre of gravity at M
    rod_inertia = 0.01125 kg m²               connecting rod, about M
    slider_mass = 6 kg                        slider with saw blade
    gravity = 9.81 m/s²                       acceleration of free fall, across the slide (-y)

Frame (z points to the viewer, angles count counter-clockwise): the slider C is at (0, 0) for crank angle 0
and moves along x; y is up. The shaft is at (sqrt(l² - e²) - r, -e), the crank pin at the shaft + r (cos t,
sin t).

Body 'crank' is the crank, driven at SPEED: a kinematic body, whose speed no force changes, and whose angle
`step` writes. The crank angle counts counter-clockwise; it is 0 at time 0. build(speed=...) takes another
speed, at as many steps a revolution; build(drive=False) leaves the crank to its mass, pinned to its shaft.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Settings: conrod's preset 'tuned' at 1000 steps a revolution. Written by the export command of conrod, format
pymunk.
"""

import math

import pymunk

SPEED = 52.35987755982988  # rad/s, of the crank angle
STEPS_PER_REVOLUTION = 1000
TIMESTEP = 0.00012  # s, of a step at SPEED
START_ANGLE = 0.0  # rad, crank angle at the start
RUN_STEPS = 2 * STEPS_PER_REVOLUTION
# The crank's body has the angle CRANK_START + CRANK_SENSE * crank angle.
CRANK, CRANK_START, CRANK_SENSE = "crank", 0.0, 1
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 147  # of the solver, in a step
ERROR_BIAS = 0.0  # share of a joint's error that is left after a second


class Model:
    """The machine in its space.

    Attributes:
        space: the `pymunk.Space`.
        bodies, constraints: those of the machine, by name.
        points: observed points: body, and place in the body's frame, whose origin is its centre of gravity [m].
        speed: of the crank angle [rad/s].
        drive: whether the crank is driven at that speed; else it moves as the forces on it demand.
        timestep: [s].
        steps: number of steps taken.
    """

    def __init__(self, space, bodies, constraints, points, speed, drive):
        self.space, self.bodies, self.constraints, self.points = space, bodies, constraints, points
        self.speed, self.drive = speed, drive
        self.timestep, self.steps = TIMESTEP * abs(SPEED / speed), 0

    @property
    def time(self):
        """Time [s] of the positions, from the number of steps: a sum of steps would drift."""
        begin = START_ANGLE / self.speed if self.drive else 0.0
        return begin + self.timestep * self.steps

    def position(self, point):
        """Position (x, y) [m] of an observed point."""
        body, place = self.points[point]
        return tuple(self.bodies[body].local_to_world(place))


def configure(space):
    """Give a space the gravity and the solver settings that conrod judges this machine with."""
    space.gravity, space.iterations = GRAVITY, ITERATIONS


def build(space=None, *, speed=SPEED, drive=True):
    """Build the machine, in motion, and return its `Model`.

    Args:
        space: space to add the machine to, which keeps its own settings; None for a new one with those of `configure`.
        speed: of the crank angle [rad/s]; negative: the other way.
        drive: whether the crank is driven at that speed. Else it is a body with its own mass on its shaft.
    """
    if not (math.isfinite(speed) and speed != 0.0):
        raise ValueError(f"speed = {speed!r} rad/s: it must be a number other than 0")
    if space is None:
        space = pymunk.Space()
        configure(space)
    # Mass [kg], moment of inertia [kg m²] about the centre of gravity: infinite on a slide of the ground.
    bodies = {
        "crank": pymunk.Body(body_type=pymunk.Body.KINEMATIC) if drive else pymunk.Body(4.0, 0.02),
        "rod": pymunk.Body(1.5, 0.01125),
        "slider": pymunk.Body(6.0, math.inf),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "crank": ((0.1861817604250837, -0.09), 0.0, (0.0, 0.0), 52.35987755982988),
        "rod": (
            (0.14309088021254188, -0.044999999999999964),
            2.8368999995743955,
            (-0.8233209854787892, 2.617993877991495),
            18.296021899528636,
        ),
        "slider": ((2.1821811789264292e-17, 0.0), 0.0, (-1.6466419709575786, 0.0), 0.0),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (speed / SPEED * vx, speed / SPEED * vy), speed / SPEED * spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "crank-pin": pymunk.PivotJoint(bodies["crank"], bodies["rod"], (0.1, 0.0), (-0.15, 0.0)),
        "slider-pin": pymunk.PivotJoint(bodies["rod"], bodies["slider"], (0.15, 0.0), (0.0, 0.0)),
        "slide": pymunk.GrooveJoint(
            ground, bodies["slider"], (-28.61817604250837, 0.0), (28.61817604250837, 0.0), (0.0, 0.0)
        ),
    }
    if not drive:
        shaft = pymunk.PivotJoint(ground, bodies["crank"], (0.1861817604250837, -0.09), (0.0, 0.0))
        constraints = {"shaft": shaft, **constraints}
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "C": ("slider", (0.0, 0.0)),
        "M": ("rod", (0.0, 0.0)),
    }
    return Model(space, bodies, constraints, points, speed, drive)


def step(model):
    """Advance a model by one time step."""
    if model.drive:
        # A kinematic body sums its angle, which would drift.
        model.bodies[CRANK].angle = CRANK_START + CRANK_SENSE * model.speed * model.time
    elif model.steps == 0:
        _start_between_steps(model)
    model.space.step(model.timestep)
    model.steps += 1


def _start_between_steps(model):
    """Advance the velocities by half a step: pymunk's belong to the middle between two steps."""
    for body in model.bodies.values():
        body.position -= 0.5 * model.timestep * body.velocity
        body.angle -= 0.5 * model.timestep * body.angular_velocity
    model.space.step(0.5 * model.timestep)


def travel(path):
    """Largest distance [m] between two positions of a path: along the line through the farthest of a few hundred."""
    few = path[:: max(1, len(path) // 300)]
    (ax, ay), (bx, by) = max(((a, b) for a in few for b in few), key=lambda pair: math.dist(*pair))
    length = math.dist((ax, ay), (bx, by))
    if length == 0.0:
        return 0.0
    along = [(x * (bx - ax) + y * (by - ay)) / length for x, y in path]
    return max(along) - min(along)


def main():
    """Run two turns, and print how far each observed point travels."""
    model = build()
    paths = {point: [model.position(point)] for point in model.points}
    for _ in range(RUN_STEPS):
        step(model)
        for point, path in paths.items():
            path.append(model.position(point))
    for point, path in paths.items():
        print(f"{point}: travels {1e3 * travel(path):.4f} mm in two turns")


if __name__ == "__main__":
    main()
