"""Chain of 10 parallel four-bars in free swing, scene four-bar-chain-10 of conrod, as a pymunk model.

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
    bodies.bar2.points.A.x = 0 m              place of A on bar2
    bodies.bar2.points.A.y = 0 m              place of A on bar2
    bodies.bar2.points.B.x = 1 m              place of B on bar2
    bodies.bar2.points.B.y = 0 m              place of B on bar2
    bodies.bar2.mass = 1 kg                   mass of bar2
    bodies.bar3.points.A.x = 0 m              place of A on bar3
    bodies.bar3.points.A.y = 0 m              place of A on bar3
    bodies.bar3.points.B.x = 1 m              place of B on bar3
    bodies.bar3.points.B.y = 0 m              place of B on bar3
    bodies.bar3.mass = 1 kg                   mass of bar3
    bodies.bar4.points.A.x = 0 m              place of A on bar4
    bodies.bar4.points.A.y = 0 m              place of A on bar4
    bodies.bar4.points.B.x = 1 m              place of B on bar4
    bodies.bar4.points.B.y = 0 m              place of B on bar4
    bodies.bar4.mass = 1 kg                   mass of bar4
    bodies.bar5.points.A.x = 0 m              place of A on bar5
    bodies.bar5.points.A.y = 0 m              place of A on bar5
    bodies.bar5.points.B.x = 1 m              place of B on bar5
    bodies.bar5.points.B.y = 0 m              place of B on bar5
    bodies.bar5.mass = 1 kg                   mass of bar5
    bodies.bar6.points.A.x = 0 m              place of A on bar6
    bodies.bar6.points.A.y = 0 m              place of A on bar6
    bodies.bar6.points.B.x = 1 m              place of B on bar6
    bodies.bar6.points.B.y = 0 m              place of B on bar6
    bodies.bar6.mass = 1 kg                   mass of bar6
    bodies.bar7.points.A.x = 0 m              place of A on bar7
    bodies.bar7.points.A.y = 0 m              place of A on bar7
    bodies.bar7.points.B.x = 1 m              place of B on bar7
    bodies.bar7.points.B.y = 0 m              place of B on bar7
    bodies.bar7.mass = 1 kg                   mass of bar7
    bodies.bar8.points.A.x = 0 m              place of A on bar8
    bodies.bar8.points.A.y = 0 m              place of A on bar8
    bodies.bar8.points.B.x = 1 m              place of B on bar8
    bodies.bar8.points.B.y = 0 m              place of B on bar8
    bodies.bar8.mass = 1 kg                   mass of bar8
    bodies.bar9.points.A.x = 0 m              place of A on bar9
    bodies.bar9.points.A.y = 0 m              place of A on bar9
    bodies.bar9.points.B.x = 1 m              place of B on bar9
    bodies.bar9.points.B.y = 0 m              place of B on bar9
    bodies.bar9.mass = 1 kg                   mass of bar9
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
    bodies.rocker10.points.A.x = 0 m          place of A on rocker10
    bodies.rocker10.points.A.y = 0 m          place of A on rocker10
    bodies.rocker10.points.B.x = 1 m          place of B on rocker10
    bodies.rocker10.points.B.y = 0 m          place of B on rocker10
    bodies.rocker10.mass = 1 kg               mass of rocker10
    bodies.rocker2.points.A.x = 0 m           place of A on rocker2
    bodies.rocker2.points.A.y = 0 m           place of A on rocker2
    bodies.rocker2.points.B.x = 1 m           place of B on rocker2
    bodies.rocker2.points.B.y = 0 m           place of B on rocker2
    bodies.rocker2.mass = 1 kg                mass of rocker2
    bodies.rocker3.points.A.x = 0 m           place of A on rocker3
    bodies.rocker3.points.A.y = 0 m           place of A on rocker3
    bodies.rocker3.points.B.x = 1 m           place of B on rocker3
    bodies.rocker3.points.B.y = 0 m           place of B on rocker3
    bodies.rocker3.mass = 1 kg                mass of rocker3
    bodies.rocker4.points.A.x = 0 m           place of A on rocker4
    bodies.rocker4.points.A.y = 0 m           place of A on rocker4
    bodies.rocker4.points.B.x = 1 m           place of B on rocker4
    bodies.rocker4.points.B.y = 0 m           place of B on rocker4
    bodies.rocker4.mass = 1 kg                mass of rocker4
    bodies.rocker5.points.A.x = 0 m           place of A on rocker5
    bodies.rocker5.points.A.y = 0 m           place of A on rocker5
    bodies.rocker5.points.B.x = 1 m           place of B on rocker5
    bodies.rocker5.points.B.y = 0 m           place of B on rocker5
    bodies.rocker5.mass = 1 kg                mass of rocker5
    bodies.rocker6.points.A.x = 0 m           place of A on rocker6
    bodies.rocker6.points.A.y = 0 m           place of A on rocker6
    bodies.rocker6.points.B.x = 1 m           place of B on rocker6
    bodies.rocker6.points.B.y = 0 m           place of B on rocker6
    bodies.rocker6.mass = 1 kg                mass of rocker6
    bodies.rocker7.points.A.x = 0 m           place of A on rocker7
    bodies.rocker7.points.A.y = 0 m           place of A on rocker7
    bodies.rocker7.points.B.x = 1 m           place of B on rocker7
    bodies.rocker7.points.B.y = 0 m           place of B on rocker7
    bodies.rocker7.mass = 1 kg                mass of rocker7
    bodies.rocker8.points.A.x = 0 m           place of A on rocker8
    bodies.rocker8.points.A.y = 0 m           place of A on rocker8
    bodies.rocker8.points.B.x = 1 m           place of B on rocker8
    bodies.rocker8.points.B.y = 0 m           place of B on rocker8
    bodies.rocker8.mass = 1 kg                mass of rocker8
    bodies.rocker9.points.A.x = 0 m           place of A on rocker9
    bodies.rocker9.points.A.y = 0 m           place of A on rocker9
    bodies.rocker9.points.B.x = 1 m           place of B on rocker9
    bodies.rocker9.points.B.y = 0 m           place of B on rocker9
    bodies.rocker9.mass = 1 kg                mass of rocker9
    ground.points.O0.x = 0 m                  place of O0 on the ground
    ground.points.O0.y = 0 m                  place of O0 on the ground
    ground.points.O1.x = 1 m                  place of O1 on the ground
    ground.points.O1.y = 0 m                  place of O1 on the ground
    ground.points.O10.x = 10 m                place of O10 on the ground
    ground.points.O10.y = 0 m                 place of O10 on the ground
    ground.points.O2.x = 2 m                  place of O2 on the ground
    ground.points.O2.y = 0 m                  place of O2 on the ground
    ground.points.O3.x = 3 m                  place of O3 on the ground
    ground.points.O3.y = 0 m                  place of O3 on the ground
    ground.points.O4.x = 4 m                  place of O4 on the ground
    ground.points.O4.y = 0 m                  place of O4 on the ground
    ground.points.O5.x = 5 m                  place of O5 on the ground
    ground.points.O5.y = 0 m                  place of O5 on the ground
    ground.points.O6.x = 6 m                  place of O6 on the ground
    ground.points.O6.y = 0 m                  place of O6 on the ground
    ground.points.O7.x = 7 m                  place of O7 on the ground
    ground.points.O7.y = 0 m                  place of O7 on the ground
    ground.points.O8.x = 8 m                  place of O8 on the ground
    ground.points.O8.y = 0 m                  place of O8 on the ground
    ground.points.O9.x = 9 m                  place of O9 on the ground
    ground.points.O9.y = 0 m                  place of O9 on the ground
    speed = 1 rad/s                           crank speed; negative is the other sense of rotation
    driver.start = 1.57079633 rad             turn of the crank at crank angle 0
    driver.from = -1.3962634 rad              crank angle at which the pass begins
    driver.to = 1.3962634 rad                 crank angle at which the pass ends
    start.bar0.turn = 0 rad                   about the turn of bar0 at the start
    start.bar1.turn = 0 rad                   about the turn of bar1 at the start
    start.bar2.turn = 0 rad                   about the turn of bar2 at the start
    start.bar3.turn = 0 rad                   about the turn of bar3 at the start
    start.bar4.turn = 0 rad                   about the turn of bar4 at the start
    start.bar5.turn = 0 rad                   about the turn of bar5 at the start
    start.bar6.turn = 0 rad                   about the turn of bar6 at the start
    start.bar7.turn = 0 rad                   about the turn of bar7 at the start
    start.bar8.turn = 0 rad                   about the turn of bar8 at the start
    start.bar9.turn = 0 rad                   about the turn of bar9 at the start
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
ITERATIONS = 800  # of the solver, in a step
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
        "bar2": pymunk.Body(1.0, 0.08333333333333333),
        "rocker3": pymunk.Body(1.0, 0.08333333333333333),
        "bar3": pymunk.Body(1.0, 0.08333333333333333),
        "rocker4": pymunk.Body(1.0, 0.08333333333333333),
        "bar4": pymunk.Body(1.0, 0.08333333333333333),
        "rocker5": pymunk.Body(1.0, 0.08333333333333333),
        "bar5": pymunk.Body(1.0, 0.08333333333333333),
        "rocker6": pymunk.Body(1.0, 0.08333333333333333),
        "bar6": pymunk.Body(1.0, 0.08333333333333333),
        "rocker7": pymunk.Body(1.0, 0.08333333333333333),
        "bar7": pymunk.Body(1.0, 0.08333333333333333),
        "rocker8": pymunk.Body(1.0, 0.08333333333333333),
        "bar8": pymunk.Body(1.0, 0.08333333333333333),
        "rocker9": pymunk.Body(1.0, 0.08333333333333333),
        "bar9": pymunk.Body(1.0, 0.08333333333333333),
        "rocker10": pymunk.Body(1.0, 0.08333333333333333),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "rocker0": (
            (2.5266077490371514e-16, 0.5),
            1.5707963267948961,
            (0.5000000000000002, -2.5266077490371524e-16),
            -1.0000000000000004,
        ),
        "bar0": (
            (0.5000000000000001, 1.0),
            2.465190328815662e-32,
            (1.0000000000000002, -9.627893571501015e-18),
            7.06057580266928e-33,
        ),
        "rocker1": (
            (0.9999999999999996, 0.5),
            1.5707963267948968,
            (0.5000000000000003, 1.1102230246251573e-16),
            -1.0000000000000007,
        ),
        "bar1": (
            (1.4999999999999998, 1.0),
            -1.232595164407831e-32,
            (1.0000000000000002, -7.237488916531243e-17),
            -3.5302879013346396e-32,
        ),
        "rocker2": (
            (1.9999999999999996, 0.5),
            1.5707963267948961,
            (0.5000000000000003, -2.220446049250315e-16),
            -1.0000000000000007,
        ),
        "bar2": (
            (2.5, 1.0),
            -5.3926038442842604e-33,
            (1.0000000000000002, -1.4713736612138585e-18),
            1.412115160533856e-32,
        ),
        "rocker3": (
            (3.000000000000001, 0.5),
            1.5707963267948961,
            (0.49999999999999994, -4.440892098500625e-16),
            -0.9999999999999999,
        ),
        "bar3": (
            (3.5, 1.0),
            4.3140830754274083e-32,
            (1.0000000000000007, -2.3684191629618567e-17),
            7.06057580266928e-33,
        ),
        "rocker4": (
            (3.9999999999999987, 0.5),
            1.570796326794897,
            (0.4999999999999999, -5.29543185200196e-33),
            -0.9999999999999998,
        ),
        "bar4": ((4.5, 1.0), 3.0814879110195774e-33, (1.0000000000000002, -9.508503618516774e-17), 0.0),
        "rocker5": ((5.0, 0.5), 1.5707963267948966, (0.5000000000000002, 1.941658345734052e-32), -1.0000000000000004),
        "bar5": (
            (5.499999999999999, 1.0),
            -4.622231866529366e-33,
            (1.0000000000000007, -7.918603290820646e-17),
            4.942403061868495e-32,
        ),
        "rocker6": (
            (6.000000000000001, 0.5),
            1.570796326794897,
            (0.49999999999999994, 4.942403061868495e-32),
            -0.9999999999999999,
        ),
        "bar6": (
            (6.500000000000002, 1.0),
            -2.6210702836895038e-33,
            (1.0000000000000004, -8.429914162303324e-17),
            -1.7651439506673198e-32,
        ),
        "rocker7": ((6.999999999999999, 0.5), 1.570796326794897, (0.5000000000000001, 0.0), -1.0000000000000002),
        "bar7": (
            (7.500000000000001, 1.0),
            -1.1555579666323415e-32,
            (1.0000000000000004, -4.022519414880679e-17),
            2.5418072889609408e-31,
        ),
        "rocker8": (
            (7.999999999999997, 0.5),
            1.5707963267948968,
            (0.5000000000000001, -1.2356007654671238e-32),
            -1.0000000000000002,
        ),
        "bar8": (
            (8.500000000000002, 1.0),
            2.2118101705072162e-33,
            (0.9999999999999999, -4.4551633430630235e-17),
            1.676886753133954e-32,
        ),
        "rocker9": ((9.0, 0.5), 1.5707963267948968, (0.5000000000000001, 1.8092725494340027e-32), -1.0000000000000002),
        "bar9": ((9.5, 1.0), -2.057585311679332e-34, (1.0, -4.1218881853616833e-17), 5.29543185200196e-33),
        "rocker10": ((9.999999999999998, 0.5), 1.5707963267948968, (0.5, 0.0), -1.0),
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
        "left2": pymunk.PivotJoint(bodies["rocker2"], bodies["bar2"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot2": pymunk.PivotJoint(ground, bodies["rocker2"], (2.0, 0.0), (-0.5, 0.0)),
        "right2": pymunk.PivotJoint(bodies["bar2"], bodies["rocker3"], (0.5, 0.0), (0.5, 0.0)),
        "left3": pymunk.PivotJoint(bodies["rocker3"], bodies["bar3"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot3": pymunk.PivotJoint(ground, bodies["rocker3"], (3.0, 0.0), (-0.5, 0.0)),
        "right3": pymunk.PivotJoint(bodies["bar3"], bodies["rocker4"], (0.5, 0.0), (0.5, 0.0)),
        "left4": pymunk.PivotJoint(bodies["rocker4"], bodies["bar4"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot4": pymunk.PivotJoint(ground, bodies["rocker4"], (4.0, 0.0), (-0.5, 0.0)),
        "right4": pymunk.PivotJoint(bodies["bar4"], bodies["rocker5"], (0.5, 0.0), (0.5, 0.0)),
        "left5": pymunk.PivotJoint(bodies["rocker5"], bodies["bar5"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot5": pymunk.PivotJoint(ground, bodies["rocker5"], (5.0, 0.0), (-0.5, 0.0)),
        "right5": pymunk.PivotJoint(bodies["bar5"], bodies["rocker6"], (0.5, 0.0), (0.5, 0.0)),
        "left6": pymunk.PivotJoint(bodies["rocker6"], bodies["bar6"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot6": pymunk.PivotJoint(ground, bodies["rocker6"], (6.0, 0.0), (-0.5, 0.0)),
        "right6": pymunk.PivotJoint(bodies["bar6"], bodies["rocker7"], (0.5, 0.0), (0.5, 0.0)),
        "left7": pymunk.PivotJoint(bodies["rocker7"], bodies["bar7"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot7": pymunk.PivotJoint(ground, bodies["rocker7"], (7.0, 0.0), (-0.5, 0.0)),
        "right7": pymunk.PivotJoint(bodies["bar7"], bodies["rocker8"], (0.5, 0.0), (0.5, 0.0)),
        "left8": pymunk.PivotJoint(bodies["rocker8"], bodies["bar8"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot8": pymunk.PivotJoint(ground, bodies["rocker8"], (8.0, 0.0), (-0.5, 0.0)),
        "right8": pymunk.PivotJoint(bodies["bar8"], bodies["rocker9"], (0.5, 0.0), (0.5, 0.0)),
        "left9": pymunk.PivotJoint(bodies["rocker9"], bodies["bar9"], (0.5, 0.0), (-0.5, 0.0)),
        "pivot9": pymunk.PivotJoint(ground, bodies["rocker9"], (9.0, 0.0), (-0.5, 0.0)),
        "right9": pymunk.PivotJoint(bodies["bar9"], bodies["rocker10"], (0.5, 0.0), (0.5, 0.0)),
        "pivot10": pymunk.PivotJoint(ground, bodies["rocker10"], (10.0, 0.0), (-0.5, 0.0)),
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
