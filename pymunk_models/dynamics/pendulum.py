"""Pendulum, a uniform bar released from the horizontal, scene pendulum of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('tip')

Source: a textbook's; its period is 4 K(sin 45 deg) sqrt(2 l / (3 g)), with K the complete elliptic integral
of the first kind.

Parameters (SI):

    bodies.bar.points.O.x = 0 m               place of O on bar
    bodies.bar.points.O.y = 0 m               place of O on bar
    bodies.bar.points.T.x = 1 m               place of T on bar
    bodies.bar.points.T.y = 0 m               place of T on bar
    bodies.bar.mass = 1 kg                    mass of bar
    ground.points.O.x = 0 m                   place of O on the ground
    ground.points.O.y = 0 m                   place of O on the ground
    speed = 6.28318531 rad/s                  crank speed; negative is the other sense of rotation
    driver.start = 0 rad                      turn of the crank at crank angle 0
    start.bar.rate = 0 rad/s                  turn rate of bar where a motion without a drive starts
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): the pivot is at (0, 0), x right, y up; the
crank angle counts counter-clockwise from the +x axis, on which the bar is released

Nothing holds the speed of body 'bar', the crank: it has its own mass, and moves as weight and loads demand.
Its start, counter-clockwise: bar 0 rad/s.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Settings: conrod's preset 'tuned' at 0.001 s a step. Written by the export command of conrod, format pymunk.
"""

import math

import pymunk

CRANK = "bar"
TIMESTEP = 0.001  # s
RUN_STEPS = 2000
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 32  # of the solver, in a step
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
        "bar": pymunk.Body(1.0, 0.08333333333333333),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "bar": ((0.5, 8.456776945386935e-18), 1.691355389077387e-17, (0.0, 0.0), 0.0),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (vx, vy), spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "pivot": pymunk.PivotJoint(ground, bodies["bar"], (0.0, 0.0), (-0.5, 0.0)),
    }
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "tip": ("bar", (0.5, 0.0)),
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
    """Run 2 s, and print how far each observed point travels."""
    model = build()
    paths = {point: [model.position(point)] for point in model.points}
    for _ in range(RUN_STEPS):
        step(model)
        for point, path in paths.items():
            path.append(model.position(point))
    for point, path in paths.items():
        print(f"{point}: travels {1e3 * travel(path):.4f} mm in 2 s")


if __name__ == "__main__":
    main()
