"""One-cylinder engine of Figure 6.2, scene one-cylinder-engine of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('A')

Source: document 001 (course module Kinematika & Dinamika Teknik 1, 2021), Figures 6.2 to 6.8, pages 43 to 46.

Parameters (SI):

    bodies.connecting-rod.points.A.x = 0 m    place of A on connecting-rod
    bodies.connecting-rod.points.A.y = 0 m    place of A on connecting-rod
    bodies.connecting-rod.points.B.x = 0.11 m  place of B on connecting-rod
    bodies.connecting-rod.points.B.y = 0 m    place of B on connecting-rod
    bodies.connecting-rod.points.C.x = 0.0366666667 m  place of C on connecting-rod
    bodies.connecting-rod.points.C.y = 0.02 m  place of C on connecting-rod
    bodies.connecting-rod.points.G.x = 0.033 m  place of G on connecting-rod
    bodies.connecting-rod.points.G.y = 0 m    place of G on connecting-rod
    bodies.connecting-rod.mass = 0.35 kg      mass of connecting-rod
    bodies.connecting-rod.inertia = 0.0006 kg m²  inertia of connecting-rod about its centre of gravity
    bodies.connecting-rod.centre_of_gravity.x = 0.033 m  centre of gravity of connecting-rod
    bodies.connecting-rod.centre_of_gravity.y = 0 m  centre of gravity of connecting-rod
    bodies.crank.points.A.x = 0.03 m          place of A on crank
    bodies.crank.points.A.y = 0 m             place of A on crank
    bodies.crank.mass = 3 kg                  mass of crank
    bodies.crank.radius = 0.06 m              radius of the uniform disc crank
    bodies.crank.centre_of_gravity.x = 0 m    centre of the uniform disc crank
    bodies.crank.centre_of_gravity.y = 0 m    centre of the uniform disc crank
    bodies.piston.mass = 0.3 kg               mass of piston
    bodies.piston.inertia = 0.0002 kg m²      inertia of piston about its centre of gravity
    bodies.piston.centre_of_gravity.x = 0 m   centre of gravity of piston
    bodies.piston.centre_of_gravity.y = 0 m   centre of gravity of piston
    ground.points.O12.x = 0 m                 place of O12 on the ground
    ground.points.O12.y = 0 m                 place of O12 on the ground
    joints.cylinder.direction = 0 rad         direction of the line on ground
    joints.cylinder.angle = 0 rad             turn of piston against ground
    speed = 314.159265 rad/s                  crank speed; negative is the other sense of rotation
    driver.start = 0 rad                      turn of the crank at crank angle 0
    start.connecting-rod.turn = 0 rad         about the turn of connecting-rod at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): the shaft O12 is at (0, 0), the cylinder's
axis is x with the piston on the + side, y is up; the crank angle counts counter-clockwise from the +x axis
(top dead centre)

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

SPEED = 314.1592653589793  # rad/s, of the crank angle
STEPS_PER_REVOLUTION = 1000
TIMESTEP = 2e-05  # s, of a step at SPEED
START_ANGLE = 0.0  # rad, crank angle at the start
RUN_STEPS = 2 * STEPS_PER_REVOLUTION
# The crank's body has the angle CRANK_START + CRANK_SENSE * crank angle.
CRANK, CRANK_START, CRANK_SENSE = "crank", 0.0, 1
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 28  # of the solver, in a step
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
        "crank": pymunk.Body(body_type=pymunk.Body.KINEMATIC) if drive else pymunk.Body(3.0, 0.0054),
        "connecting-rod": pymunk.Body(0.35, 0.0006),
        "piston": pymunk.Body(0.3, math.inf),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "crank": ((0.0, 0.0), 0.0, (0.0, 0.0), 314.1592653589793),
        "connecting-rod": ((0.063, 0.0), 0.0, (0.0, 6.5973445725385655), -85.679799643358),
        "piston": ((0.14, 0.0), 0.0, (0.0, 0.0), 0.0),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (speed / SPEED * vx, speed / SPEED * vy), speed / SPEED * spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "A": pymunk.PivotJoint(bodies["crank"], bodies["connecting-rod"], (0.03, 0.0), (-0.033, 0.0)),
        "B": pymunk.PivotJoint(bodies["connecting-rod"], bodies["piston"], (0.077, 0.0), (0.0, 0.0)),
        "cylinder": pymunk.GrooveJoint(
            ground, bodies["piston"], (-14.000000000000002, 0.0), (14.000000000000002, 0.0), (0.0, 0.0)
        ),
    }
    if not drive:
        shaft = pymunk.PivotJoint(ground, bodies["crank"], (0.0, 0.0), (0.0, 0.0))
        constraints = {"O12": shaft, **constraints}
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "A": ("crank", (0.03, 0.0)),
        "B": ("piston", (0.0, 0.0)),
        "C": ("connecting-rod", (0.0036666666666666653, 0.02)),
        "G": ("connecting-rod", (0.0, 0.0)),
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
