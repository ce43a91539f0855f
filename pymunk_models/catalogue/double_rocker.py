"""Grashof double rocker, scene double-rocker of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('B')

Source: Grashof's condition: a four-bar linkage whose coupler is the shortest link, with s + l <= p + q, is a
double rocker (Norton, Design of Machinery, chapter 2); dimensions are conrod's.

Parameters (SI):

    bodies.coupler.points.A.x = 0 m           place of A on coupler
    bodies.coupler.points.A.y = 0 m           place of A on coupler
    bodies.coupler.points.B.x = 0.03 m        place of B on coupler
    bodies.coupler.points.B.y = 0 m           place of B on coupler
    bodies.coupler.points.P.x = 0.015 m       place of P on coupler
    bodies.coupler.points.P.y = 0.02 m        place of P on coupler
    bodies.coupler.mass = 0.3 kg              mass of coupler
    bodies.follower.points.B.x = 0.07 m       place of B on follower
    bodies.follower.points.B.y = 0 m          place of B on follower
    bodies.follower.points.O.x = 0 m          place of O on follower
    bodies.follower.points.O.y = 0 m          place of O on follower
    bodies.follower.mass = 0.7 kg             mass of follower
    bodies.input.points.A.x = 0.08 m          place of A on input
    bodies.input.points.A.y = 0 m             place of A on input
    bodies.input.points.O.x = 0 m             place of O on input
    bodies.input.points.O.y = 0 m             place of O on input
    bodies.input.mass = 0.8 kg                mass of input
    ground.points.O2.x = 0 m                  place of O2 on the ground
    ground.points.O2.y = 0 m                  place of O2 on the ground
    ground.points.O4.x = 0.1 m                place of O4 on the ground
    ground.points.O4.y = 0 m                  place of O4 on the ground
    speed = 10 rad/s                          crank speed; negative is the other sense of rotation
    driver.start = 0.785398163 rad            turn of the crank at crank angle 0
    driver.from = -0.296705973 rad            crank angle at which the pass begins
    driver.to = 0.27925268 rad                crank angle at which the pass ends
    start.coupler.B.x = 0.086 m               about where B of coupler is at the start
    start.coupler.B.y = 0.069 m               about where B of coupler is at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): the input's pivot O2 is at (0, 0) and the
follower's O4 on the +x axis, y is up; the input stands at 45 deg at crank angle 0

Body 'input' is the crank, driven at SPEED: a kinematic body, whose speed no force changes, and whose angle
`step` writes. The crank angle counts counter-clockwise; it is 0 at time 0. build(speed=...) takes another
speed, at as many steps a revolution; build(drive=False) leaves the crank to its mass, pinned to its shaft.
The input cannot turn fully: it begins at crank angle -17 deg and reaches 16 deg after RUN_STEPS steps. STOP
THERE: beyond, nothing is promised.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Settings: conrod's preset 'tuned' at 1000 steps a revolution. Written by the export command of conrod, format
pymunk.
"""

import math

import pymunk

SPEED = 10.0  # rad/s, of the crank angle
STEPS_PER_REVOLUTION = 1000
TIMESTEP = 0.0006283185307179586  # s, of a step at SPEED
START_ANGLE = -0.29670597283903605  # rad, crank angle at the start
RUN_STEPS = 91  # of the one pass that the input can make
# The crank's body has the angle CRANK_START + CRANK_SENSE * crank angle.
CRANK, CRANK_START, CRANK_SENSE = "input", 0.7853981633974483, 1
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 75  # of the solver, in a step
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
        speed: of the crank angle [rad/s], of the sign of SPEED.
        drive: whether the crank is driven at that speed. Else it is a body with its own mass on its shaft.
    """
    if not (math.isfinite(speed) and speed * SPEED > 0.0):
        raise ValueError(f"speed = {speed!r} rad/s: it must be a number of the sign of {SPEED}")
    if space is None:
        space = pymunk.Space()
        configure(space)
    # Mass [kg], moment of inertia [kg m²] about the centre of gravity: infinite on a slide of the ground.
    bodies = {
        "input": pymunk.Body(body_type=pymunk.Body.KINEMATIC) if drive else pymunk.Body(0.8, 0.0004266666666666667),
        "coupler": pymunk.Body(0.3, 2.25e-05),
        "follower": pymunk.Body(0.7, 0.00028583333333333336),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "input": (
            ((0.0, 0.0), 0.48869219055841223, (0.0, 0.0), 10.0)
            if drive
            else ((0.03531790371435708, 0.01877886251143563), 0.48869219055841223, (-0.1877886251143563, 0.3531790371435708), 10.0)
        ),
        "coupler": (
            (0.07447692261886435, 0.052057581370297513),
            1.3118373834850734,
            (0.32592011551849354, 0.5205264272101536),
            -48.379607972579876,
        ),
        "follower": (
            (0.08915901890450728, 0.03327871885886188),
            1.885718336098878,
            (0.5137087406328495, 0.16734739006658259),
            -15.436553997512217,
        ),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (speed / SPEED * vx, speed / SPEED * vy), speed / SPEED * spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "A": pymunk.PivotJoint(
            bodies["input"], bodies["coupler"], (0.08, 0.0) if drive else (0.04, 0.0), (-0.015, 0.0)
        ),
        "B": pymunk.PivotJoint(bodies["coupler"], bodies["follower"], (0.015, 0.0), (0.035, 0.0)),
        "O4": pymunk.PivotJoint(ground, bodies["follower"], (0.1, 0.0), (-0.035, 0.0)),
    }
    if not drive:
        shaft = pymunk.PivotJoint(ground, bodies["input"], (0.0, 0.0), (-0.04, 0.0))
        constraints = {"O2": shaft, **constraints}
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "B": ("follower", (0.035, 0.0)),
        "P": ("coupler", (0.0, 0.02)),
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
    """Run one pass, and print how far each observed point travels."""
    model = build()
    paths = {point: [model.position(point)] for point in model.points}
    for _ in range(RUN_STEPS):
        step(model)
        for point, path in paths.items():
            path.append(model.position(point))
    for point, path in paths.items():
        print(f"{point}: travels {1e3 * travel(path):.4f} mm in one pass")


if __name__ == "__main__":
    main()
