"""Leg of a Strandbeest, scene jansen-leg of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('U')

Source: Theo Jansen's published numbers of the Strandbeest's leg: a = 38, b = 41.5, c = 39.3, d = 40.1, e =
55.8, f = 39.4, g = 36.7, h = 65.7, i = 49, j = 50, k = 61.9, l = 7.8, m = 15.

Parameters (SI):

    bodies.c.points.V.x = 0.393 m             place of V on c
    bodies.c.points.V.y = 0 m                 place of V on c
    bodies.c.points.Y.x = 0 m                 place of Y on c
    bodies.c.points.Y.y = 0 m                 place of Y on c
    bodies.c.mass = 0.393 kg                  mass of c
    bodies.crank.points.X.x = 0.15 m          place of X on crank
    bodies.crank.points.X.y = 0 m             place of X on crank
    bodies.crank.points.Z.x = 0 m             place of Z on crank
    bodies.crank.points.Z.y = 0 m             place of Z on crank
    bodies.crank.mass = 0.15 kg               mass of crank
    bodies.f.points.T.x = 0.394 m             place of T on f
    bodies.f.points.T.y = 0 m                 place of T on f
    bodies.f.points.U.x = 0 m                 place of U on f
    bodies.f.points.U.y = 0 m                 place of U on f
    bodies.f.mass = 0.394 kg                  mass of f
    bodies.j.points.W.x = 0.5 m               place of W on j
    bodies.j.points.W.y = 0 m                 place of W on j
    bodies.j.points.X.x = 0 m                 place of X on j
    bodies.j.points.X.y = 0 m                 place of X on j
    bodies.j.mass = 0.5 kg                    mass of j
    bodies.k.points.V.x = 0.619 m             place of V on k
    bodies.k.points.V.y = 0 m                 place of V on k
    bodies.k.points.X.x = 0 m                 place of X on k
    bodies.k.points.X.y = 0 m                 place of X on k
    bodies.k.mass = 0.619 kg                  mass of k
    bodies.lower.points.S.x = -0.0774659401 m  place of S on lower
    bodies.lower.points.S.y = 0.483837812 m   place of S on lower
    bodies.lower.points.T.x = 0.367 m         place of T on lower
    bodies.lower.points.T.y = 0 m             place of T on lower
    bodies.lower.points.V.x = 0 m             place of V on lower
    bodies.lower.points.V.y = 0 m             place of V on lower
    bodies.lower.mass = 1.514 kg              mass of lower
    bodies.lower.inertia = 0.06709 kg m²      inertia of lower about its centre of gravity
    bodies.lower.centre_of_gravity.x = 0.09477 m  centre of gravity of lower
    bodies.lower.centre_of_gravity.y = 0.1833 m  centre of gravity of lower
    bodies.upper.points.U.x = 0.0260987952 m  place of U on upper
    bodies.upper.points.U.y = 0.400149788 m   place of U on upper
    bodies.upper.points.W.x = 0.415 m         place of W on upper
    bodies.upper.points.W.y = 0 m             place of W on upper
    bodies.upper.points.Y.x = 0 m             place of Y on upper
    bodies.upper.points.Y.y = 0 m             place of Y on upper
    bodies.upper.mass = 1.374 kg              mass of upper
    bodies.upper.inertia = 0.04902 kg m²      inertia of upper about its centre of gravity
    bodies.upper.centre_of_gravity.x = 0.156 m  centre of gravity of upper
    bodies.upper.centre_of_gravity.y = 0.1396 m  centre of gravity of upper
    ground.points.Y.x = -0.38 m               place of Y on the ground
    ground.points.Y.y = -0.078 m              place of Y on the ground
    ground.points.Z.x = 0 m                   place of Z on the ground
    ground.points.Z.y = 0 m                   place of Z on the ground
    speed = 3.14159265 rad/s                  crank speed; negative is the other sense of rotation
    driver.start = 0 rad                      turn of the crank at crank angle 0
    start.c.V.x = -0.27 m                     about where V of c is at the start
    start.c.V.y = -0.46 m                     about where V of c is at the start
    start.f.T.x = -0.59 m                     about where T of f is at the start
    start.f.T.y = -0.28 m                     about where T of f is at the start
    start.j.W.x = -0.24 m                     about where W of j is at the start
    start.j.W.y = 0.31 m                      about where W of j is at the start
    start.k.V.x = -0.27 m                     about where V of k is at the start
    start.k.V.y = -0.46 m                     about where V of k is at the start
    start.lower.S.x = -0.43 m                 about where S of lower is at the start
    start.lower.S.y = -0.92 m                 about where S of lower is at the start
    start.lower.T.x = -0.59 m                 about where T of lower is at the start
    start.lower.T.y = -0.28 m                 about where T of lower is at the start
    start.upper.U.x = -0.75 m                 about where U of upper is at the start
    start.upper.U.y = 0.08 m                  about where U of upper is at the start
    start.upper.W.x = -0.24 m                 about where W of upper is at the start
    start.upper.W.y = 0.31 m                  about where W of upper is at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): the crank's shaft Z is at (0, 0), the legs'
fixed pivot Y at (-a, -l) = (-38 cm, -7.8 cm), y is up; the crank angle counts from the +x axis

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

SPEED = 3.141592653589793  # rad/s, of the crank angle
STEPS_PER_REVOLUTION = 1000
TIMESTEP = 0.002  # s, of a step at SPEED
START_ANGLE = 0.0  # rad, crank angle at the start
RUN_STEPS = 2 * STEPS_PER_REVOLUTION
# The crank's body has the angle CRANK_START + CRANK_SENSE * crank angle.
CRANK, CRANK_START, CRANK_SENSE = "crank", 0.0, 1
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 4572  # of the solver, in a step
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
        "crank": pymunk.Body(body_type=pymunk.Body.KINEMATIC) if drive else pymunk.Body(0.15, 0.00028125),
        "j": pymunk.Body(0.5, 0.010416666666666666),
        "k": pymunk.Body(0.619, 0.019764721583333332),
        "upper": pymunk.Body(1.374, 0.04902),
        "c": pymunk.Body(0.393, 0.005058204749999999),
        "f": pymunk.Body(0.394, 0.0050969153333333345),
        "lower": pymunk.Body(1.514, 0.06709),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "crank": (
            ((0.0, 0.0), 0.0, (0.0, 0.0), 3.141592653589793)
            if drive
            else ((0.075, 0.0), 0.0, (0.0, 0.23561944901923448), 3.141592653589793)
        ),
        "j": (
            (-0.04506767548563895, 0.1563604872742134),
            2.465894844308564,
            (-0.14675616716466106, 0.2881531012937472),
            0.9385757855006618,
        ),
        "k": (
            (-0.05976053515786478, -0.22757585085040588),
            -2.3154810446395375,
            (0.193981877786407, 0.29244249963611324),
            0.8523834012331938,
        ),
        "upper": (
            (-0.45885725975537284, 0.11592187237099802),
            1.2270429474429436,
            (-0.14567546956727276, -0.05923812617524191),
            0.7512070081943952,
        ),
        "c": (
            (-0.32476053515786485, -0.2665758508504058),
            -1.2858386142179512,
            (0.19398187778640694, 0.05682305061687874),
            1.0286676523617526,
        ),
        "f": (
            (-0.6701294017117554, -0.09954880012425801),
            -1.1647326082437521,
            (0.07356418317917782, -0.19327764781261475),
            1.068238803418217,
        ),
        "lower": (
            (-0.4400918624244748, -0.5712802846569266),
            2.645707522702991,
            (0.46847800831637876, -0.004614016274981966),
            0.6933198588498339,
        ),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (speed / SPEED * vx, speed / SPEED * vy), speed / SPEED * spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "X-j": pymunk.PivotJoint(bodies["crank"], bodies["j"], (0.15, 0.0) if drive else (0.075, 0.0), (-0.25, 0.0)),
        "X-k": pymunk.PivotJoint(bodies["crank"], bodies["k"], (0.15, 0.0) if drive else (0.075, 0.0), (-0.3095, 0.0)),
        "W": pymunk.PivotJoint(bodies["j"], bodies["upper"], (0.25, 0.0), (0.259, -0.1396)),
        "V-c": pymunk.PivotJoint(bodies["k"], bodies["c"], (0.3095, 0.0), (0.19649999999999998, 0.0)),
        "U": pymunk.PivotJoint(
            bodies["upper"], bodies["f"], (-0.12990120481927706, 0.26054978806706214), (-0.197, 0.0)
        ),
        "Y-upper": pymunk.PivotJoint(ground, bodies["upper"], (-0.38, -0.078), (-0.156, -0.1396)),
        "V-lower": pymunk.PivotJoint(
            bodies["c"], bodies["lower"], (0.19649999999999998, 0.0), (-0.09477000000000001, -0.1833)
        ),
        "Y-c": pymunk.PivotJoint(ground, bodies["c"], (-0.38, -0.078), (-0.19649999999999998, 0.0)),
        "T": pymunk.PivotJoint(bodies["f"], bodies["lower"], (0.197, 0.0), (0.27223, -0.1833)),
    }
    if not drive:
        shaft = pymunk.PivotJoint(ground, bodies["crank"], (0.0, 0.0), (-0.075, 0.0))
        constraints = {"Z": shaft, **constraints}
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "U": ("upper", (-0.12990120481927706, 0.26054978806706214)),
        "foot": ("lower", (-0.17223594005449597, 0.3005378118041967)),
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
