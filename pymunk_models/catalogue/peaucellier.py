"""Peaucellier's straight-line linkage, scene peaucellier of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('B')

Source: C.-N. Peaucellier's inversor of 1864 (A. B. Kempe, How to Draw a Straight Line, 1877); dimensions are
conrod's.

Parameters (SI):

    bodies.ab.points.A.x = 0 m                place of A on ab
    bodies.ab.points.A.y = 0 m                place of A on ab
    bodies.ab.points.B.x = 0.08 m             place of B on ab
    bodies.ab.points.B.y = 0 m                place of B on ab
    bodies.ab.mass = 0.4 kg                   mass of ab
    bodies.ad.points.A.x = 0 m                place of A on ad
    bodies.ad.points.A.y = 0 m                place of A on ad
    bodies.ad.points.D.x = 0.08 m             place of D on ad
    bodies.ad.points.D.y = 0 m                place of D on ad
    bodies.ad.mass = 0.4 kg                   mass of ad
    bodies.cb.points.B.x = 0.08 m             place of B on cb
    bodies.cb.points.B.y = 0 m                place of B on cb
    bodies.cb.points.C.x = 0 m                place of C on cb
    bodies.cb.points.C.y = 0 m                place of C on cb
    bodies.cb.mass = 0.4 kg                   mass of cb
    bodies.cd.points.C.x = 0 m                place of C on cd
    bodies.cd.points.C.y = 0 m                place of C on cd
    bodies.cd.points.D.x = 0.08 m             place of D on cd
    bodies.cd.points.D.y = 0 m                place of D on cd
    bodies.cd.mass = 0.4 kg                   mass of cd
    bodies.crank.points.A.x = 0.12 m          place of A on crank
    bodies.crank.points.A.y = 0 m             place of A on crank
    bodies.crank.points.Q.x = 0 m             place of Q on crank
    bodies.crank.points.Q.y = 0 m             place of Q on crank
    bodies.crank.mass = 0.6 kg                mass of crank
    bodies.lower-arm.points.D.x = 0.2 m       place of D on lower-arm
    bodies.lower-arm.points.D.y = 0 m         place of D on lower-arm
    bodies.lower-arm.points.O.x = 0 m         place of O on lower-arm
    bodies.lower-arm.points.O.y = 0 m         place of O on lower-arm
    bodies.lower-arm.mass = 1 kg              mass of lower-arm
    bodies.upper-arm.points.B.x = 0.2 m       place of B on upper-arm
    bodies.upper-arm.points.B.y = 0 m         place of B on upper-arm
    bodies.upper-arm.points.O.x = 0 m         place of O on upper-arm
    bodies.upper-arm.points.O.y = 0 m         place of O on upper-arm
    bodies.upper-arm.mass = 1 kg              mass of upper-arm
    ground.points.O.x = 0 m                   place of O on the ground
    ground.points.O.y = 0 m                   place of O on the ground
    ground.points.Q.x = 0.12 m                place of Q on the ground
    ground.points.Q.y = 0 m                   place of Q on the ground
    speed = 3 rad/s                           crank speed; negative is the other sense of rotation
    driver.start = 0 rad                      turn of the crank at crank angle 0
    driver.from = -1.04719755 rad             crank angle at which the pass begins
    driver.to = 1.04719755 rad                crank angle at which the pass ends
    start.cb.C.x = 0.14 m                     about where C of cb is at the start
    start.cb.C.y = 0 m                        about where C of cb is at the start
    start.cd.C.x = 0.14 m                     about where C of cd is at the start
    start.cd.C.y = 0 m                        about where C of cd is at the start
    start.lower-arm.turn = -0.296705973 rad   about the turn of lower-arm at the start
    start.upper-arm.turn = 0.296705973 rad    about the turn of upper-arm at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): the long arms' pivot O is at (0, 0), the
crank's pivot Q on the +x axis; C moves along y; crank angle 0 is where the crank points along +x

Body 'crank' is the crank, driven at SPEED: a kinematic body, whose speed no force changes, and whose angle
`step` writes. The crank angle counts counter-clockwise; it is 0 at time 0. build(speed=...) takes another
speed, at as many steps a revolution; build(drive=False) leaves the crank to its mass, pinned to its shaft.
The input cannot turn fully: it begins at crank angle -60 deg and reaches 60 deg after RUN_STEPS steps. STOP
THERE: beyond, nothing is promised.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Settings: conrod's preset 'tuned' at 1000 steps a revolution. Written by the export command of conrod, format
pymunk.
"""

import math

import pymunk

SPEED = 3.0  # rad/s, of the crank angle
STEPS_PER_REVOLUTION = 1000
TIMESTEP = 0.0020943951023931952  # s, of a step at SPEED
START_ANGLE = -1.0471975511965976  # rad, crank angle at the start
RUN_STEPS = 333  # of the one pass that the input can make
# The crank's body has the angle CRANK_START + CRANK_SENSE * crank angle.
CRANK, CRANK_START, CRANK_SENSE = "crank", 0.0, 1
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 241  # of the solver, in a step
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
        "crank": pymunk.Body(body_type=pymunk.Body.KINEMATIC) if drive else pymunk.Body(0.6, 0.00072),
        "ad": pymunk.Body(0.4, 0.00021333333333333336),
        "ab": pymunk.Body(0.4, 0.00021333333333333336),
        "lower-arm": pymunk.Body(1.0, 0.003333333333333334),
        "upper-arm": pymunk.Body(1.0, 0.003333333333333334),
        "cd": pymunk.Body(0.4, 0.00021333333333333336),
        "cb": pymunk.Body(0.4, 0.00021333333333333336),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "crank": (
            ((0.12, 0.0), -1.0471975511965976, (0.0, 0.0), 3.0)
            if drive
            else ((0.15, -0.05196152422706631), -1.0471975511965976, (0.15588457268119893, 0.09), 3.0)
        ),
        "ad": (
            (0.15085145784487325, -0.13131579366579038),
            -2.3872378741217704,
            (0.29563668466023996, 0.1971665054819936),
            -0.5889318714683734,
        ),
        "ab": (
            (0.18914854215512675, -0.06498329785868237),
            1.3400403229251732,
            (0.17201703338335683, 0.21283349451800643),
            3.5889318714683744,
        ),
        "lower-arm": (
            (0.06085145784487325, -0.07935426943872406),
            -0.9166089684884341,
            (0.13975211197904097, 0.10716650548199358),
            1.761116483933546,
        ),
        "upper-arm": (
            (0.09914854215512676, -0.013021773631616055),
            -0.1305885827081635,
            (0.01613246070215793, 0.12283349451800643),
            1.2388835160664535,
        ),
        "cd": (
            (0.1308514578448733, -0.11976878828199788),
            -1.8015523306646208,
            (0.13975211197904086, 0.24716650548199376),
            3.5889318714683762,
        ),
        "cb": (
            (0.1691485421551268, -0.053436292474889874),
            0.7543547794680233,
            (0.016132460702157833, 0.2628334945180066),
            -0.5889318714683773,
        ),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (speed / SPEED * vx, speed / SPEED * vy), speed / SPEED * spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "A-lower": pymunk.PivotJoint(
            bodies["crank"], bodies["ad"], (0.12, 0.0) if drive else (0.06, 0.0), (-0.04, 0.0)
        ),
        "A-upper": pymunk.PivotJoint(
            bodies["crank"], bodies["ab"], (0.12, 0.0) if drive else (0.06, 0.0), (-0.04, 0.0)
        ),
        "D-inner": pymunk.PivotJoint(bodies["ad"], bodies["lower-arm"], (0.04, 0.0), (0.1, 0.0)),
        "B-inner": pymunk.PivotJoint(bodies["ab"], bodies["upper-arm"], (0.04, 0.0), (0.1, 0.0)),
        "D-outer": pymunk.PivotJoint(bodies["lower-arm"], bodies["cd"], (0.1, 0.0), (0.04, 0.0)),
        "O-lower": pymunk.PivotJoint(ground, bodies["lower-arm"], (0.0, 0.0), (-0.1, 0.0)),
        "B-outer": pymunk.PivotJoint(bodies["upper-arm"], bodies["cb"], (0.1, 0.0), (0.04, 0.0)),
        "O-upper": pymunk.PivotJoint(ground, bodies["upper-arm"], (0.0, 0.0), (-0.1, 0.0)),
        "C": pymunk.PivotJoint(bodies["cd"], bodies["cb"], (-0.04, 0.0), (-0.04, 0.0)),
    }
    if not drive:
        shaft = pymunk.PivotJoint(ground, bodies["crank"], (0.12, 0.0), (-0.06, 0.0))
        constraints = {"Q": shaft, **constraints}
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "B": ("upper-arm", (0.1, 0.0)),
        "C": ("cb", (-0.04, 0.0)),
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
