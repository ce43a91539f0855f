"""Chain of 2 parallel four-bars in free swing, scene four-bar-chain-2 of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('tip')

Source: the benchmark N-four-bar of the IFToMM library of computational benchmark problems.

Parameters (SI):

    bodies.bar0.points.A.x = 0 m              place of A on bar0
    bodies.bar0.points.A.y = 0 m              place of A on bar0
    bodies.bar0.points.B.x = 1 m              place of B on bar0
    bodies.bar0.points.B.y = 0 m              place of B on bar0
    bodies.bar0.mass = 1 kg                   mass of bar0
    bodies.bar1.points.A.x = 0 m              place of A on bar1
    bodies.bar1.points.A.y = 0 m              place of A on bar1
    bodies.bar1.points.B.x = 1 m              place of B on bar1
    bodies.bar1.points.B.y = 0 m              place of B on bar1
    bodies.bar1.mass = 1 kg                   mass of bar1
    bodies.rocker0.points.A.x = 0 m           place of A on rocker0
    bodies.rocker0.points.A.y = 0 m           place of A on rocker0
    bodies.rocker0.points.B.x = 1 m           place of B on rocker0
    bodies.rocker0.points.B.y = 0 m           place of B on rocker0
    bodies.rocker0.mass = 1 kg                mass of rocker0
    bodies.rocker1.points.A.x = 0 m           place of A on rocker1
    bodies.rocker1.points.A.y = 0 m           place of A on rocker1
    bodies.rocker1.points.B.x = 1 m           place of B on rocker1
    bodies.rocker1.points.B.y = 0 m           place of B on rocker1
    bodies.rocker1.mass = 1 kg                mass of rocker1
    bodies.rocker2.points.A.x = 0 m           place of A on rocker2
    bodies.rocker2.points.A.y = 0 m           place of A on rocker2
    bodies.rocker2.points.B.x = 1 m           place of B on rocker2
    bodies.rocker2.points.B.y = 0 m           place of B on rocker2
    bodies.rocker2.mass = 1 kg                mass of rocker2
    ground.points.O0.x = 0 m                  place of O0 on the ground
    ground.points.O0.y = 0 m                  place of O0 on the ground
    ground.points.O1.x = 1 m                  place of O1 on the ground
    ground.points.O1.y = 0 m                  place of O1 on the ground
    ground.points.O2.x = 2 m                  place of O2 on the ground
    ground.points.O2.y = 0 m                  place of O2 on the ground
    speed = 1 rad/s                           crank speed; negative is the other sense of rotation
    driver.start = 1.57079633 rad             turn of the crank at crank angle 0
    driver.from = -1.3962634 rad              crank angle at which the pass begins
    driver.to = 1.3962634 rad                 crank angle at which the pass ends
    start.bar0.turn = 0 rad                   about the turn of bar0 at the start
    start.bar1.turn = 0 rad                   about the turn of bar1 at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): the first rocker's pivot is at (0, 0), the
others on +x; y is up; crank angles count clockwise from upright

Nothing holds the speed of body 'rocker0', the crank: it has its own mass, and moves as weight and loads
demand. Its start, counter-clockwise: rocker0 -1 rad/s.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Settings: conrod's preset 'tuned' at 0.00628319 s a step. Written by the export command of conrod, format
pymunk.
"""

import math

import pymunk

CRANK = "rocker0"
TIMESTEP = 0.006283185307179587  # s
RUN_STEPS = 2000
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 160  # of the solver, in a step
ERROR_BIAS = 0.0  # share of a joint's error that is left after a second


class Model:
    """The machine in its space.

    Attributes:
        space: the `pymunk.Space`.
        bodies, constraints: those of the machine, by name.
        points: observed points: body, and place in the body's frame, whose origin is its centre of gravity [m].
        timestep: [s].
        steps: number of steps taken.
    """

    def __init__(self, space, bodies, constraints, points):
        self.space, self.bodies, self.constraints, self.points = space, bodies, constraints, points
        self.timestep, self.steps = TIMESTEP, 0

    @property
    def time(self):
        """Time [s] of the positions, from the number of steps: a sum of steps would drift."""
        return self.timestep * self.steps

    def position(self, point):
        """Position (x, y) [m] of an observed point."""
        body, place = self.points[point]
        return tuple(self.bodies[body].local_to_world(place))


def configure(space):
    """Give a space the gravity and the solver settings that conrod judges this machine with."""
    space.gravity, space.iterations = GRAVITY, ITERATIONS


def build(space=None):
    """Build the machine, in motion, and return its `Model`.

    Args:
        space: space to add the machine to, which keeps its own settings; None for a new one with those of `configure`.
    """
    if space is None:
        space = pymunk.Space()
        configure(space)
    # Mass [kg], moment of inertia [kg m²] about the centre of gravity: infinite on a slide of the ground.
    bodies = {
        "rocker0": pymunk.Body(1.0, 0.08333333333333333),
        "bar0": pymunk.Body(1.0, 0.08333333333333333),
        "rocker1": pymunk.Body(1.0, 0.08333333333333333),
        "bar1": pymunk.Body(1.0, 0.08333333333333333),
        "rocker2": pymunk.Body(1.0, 0.08333333333333333),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "rocker0": (
            (-1.9142843494634747e-16, 0.5),
            1.570796326794897,
            (0.5000000000000001, 1.9142843494634752e-16),
            -1.0000000000000002,
        ),
        "bar0": ((0.5, 0.9999999999999999), 0.0, (1.0000000000000002, -7.04646013651229e-17), 6.545895618839419e-32),
        "rocker1": ((0.9999999999999993, 0.5), 1.5707963267948972, (0.5, 3.3306690738754696e-16), -1.0),
        "bar1": (
            (1.5, 0.9999999999999999),
            -1.5407439555097887e-33,
            (1.0000000000000002, -6.173694223261294e-17),
            1.03356246613254e-31,
        ),
        "rocker2": (
            (1.9999999999999996, 0.5),
            1.5707963267948977,
            (0.5000000000000001, 4.440892098500627e-16),
            -1.0000000000000002,
        ),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (vx, vy), spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "pivot0": pymunk.PivotJoint(ground, bodies["rocker0"], (0.0, 0.0), (-0.5, 0.0)),
        "left0": pymunk.PivotJoint(bodies["rocker0"], bodies["bar0"], (0.5, 0.0), (-0.5, 0.0)),
        "right0": pymunk.PivotJoint(bodies["bar0"], bodies["rocker1"], (0.5, 0.0), (0.5, 0.0)),
        "left1": pymunk.PivotJoint(bodies["rocker1"], bodies["bar1"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot1": pymunk.PivotJoint(ground, bodies["rocker1"], (1.0, 0.0), (-0.5, 0.0)),
        "right1": pymunk.PivotJoint(bodies["bar1"], bodies["rocker2"], (0.5, 0.0), (0.5, 0.0)),
        "pivot2": pymunk.PivotJoint(ground, bodies["rocker2"], (2.0, 0.0), (-0.5, 0.0)),
    }
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "tip": ("rocker0", (0.5, 0.0)),
    }
    return Model(space, bodies, constraints, points)


def step(model):
    """Advance a model by one time step."""
    if model.steps == 0:
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
    """Run 12.5664 s, and print how far each observed point travels."""
    model = build()
    paths = {point: [model.position(point)] for point in model.points}
    for _ in range(RUN_STEPS):
        step(model)
        for point, path in paths.items():
            path.append(model.position(point))
    for point, path in paths.items():
        print(f"{point}: travels {1e3 * travel(path):.4f} mm in 12.5664 s")


if __name__ == "__main__":
    main()
