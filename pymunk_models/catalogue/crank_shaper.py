"""Crank-shaper quick return, scene crank-shaper of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('C')

Source: the quick return of a shaping machine, an inversion of the slider-crank (Norton, Design of Machinery,
chapter 2); dimensions are conrod's.

Parameters (SI):

    bodies.block.mass = 0.6 kg                mass of block
    bodies.block.inertia = 0.0002 kg m²       inertia of block about its centre of gravity
    bodies.block.centre_of_gravity.x = 0 m    centre of gravity of block
    bodies.block.centre_of_gravity.y = 0 m    centre of gravity of block
    bodies.crank.points.A.x = 0.1 m           place of A on crank
    bodies.crank.points.A.y = 0 m             place of A on crank
    bodies.crank.points.O.x = 0 m             place of O on crank
    bodies.crank.points.O.y = 0 m             place of O on crank
    bodies.crank.mass = 2 kg                  mass of crank
    bodies.lever.points.C.x = 0.4 m           place of C on lever
    bodies.lever.points.C.y = 0 m             place of C on lever
    bodies.lever.points.O.x = 0 m             place of O on lever
    bodies.lever.points.O.y = 0 m             place of O on lever
    bodies.lever.mass = 4 kg                  mass of lever
    bodies.link.points.C.x = 0 m              place of C on link
    bodies.link.points.C.y = 0 m              place of C on link
    bodies.link.points.D.x = 0.15 m           place of D on link
    bodies.link.points.D.y = 0 m              place of D on link
    bodies.link.mass = 0.8 kg                 mass of link
    bodies.ram.mass = 15 kg                   mass of ram
    bodies.ram.inertia = 0.2 kg m²            inertia of ram about its centre of gravity
    bodies.ram.centre_of_gravity.x = 0 m      centre of gravity of ram
    bodies.ram.centre_of_gravity.y = 0 m      centre of gravity of ram
    ground.points.O2.x = 0 m                  place of O2 on the ground
    ground.points.O2.y = 0 m                  place of O2 on the ground
    ground.points.O4.x = 0 m                  place of O4 on the ground
    ground.points.O4.y = -0.2 m               place of O4 on the ground
    ground.points.line.x = 0 m                place of line on the ground
    ground.points.line.y = 0.173 m            place of line on the ground
    joints.slide.direction = 0 rad            direction of the line on ground
    joints.slide.angle = 0 rad                turn of ram against ground
    joints.slot.direction = 0 rad             direction of the line on lever
    joints.slot.angle = 0 rad                 turn of block against lever
    speed = 4.1887902 rad/s                   crank speed; negative is the other sense of rotation
    driver.start = 0 rad                      turn of the crank at crank angle 0
    start.lever.turn = 1.09955743 rad         about the turn of lever at the start
    start.link.turn = 0 rad                   about the turn of link at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): the crank's shaft O2 is at (0, 0), the lever's
O4 at (0, -200 mm); the ram D moves along x, y is up; the crank angle counts from the +x axis

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

SPEED = 4.1887902047863905  # rad/s, of the crank angle
STEPS_PER_REVOLUTION = 1000
TIMESTEP = 0.0015  # s, of a step at SPEED
START_ANGLE = 0.0  # rad, crank angle at the start
RUN_STEPS = 2 * STEPS_PER_REVOLUTION
# The crank's body has the angle CRANK_START + CRANK_SENSE * crank angle.
CRANK, CRANK_START, CRANK_SENSE = "crank", 0.0, 1
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 9450  # of the solver, in a step
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
        "crank": pymunk.Body(body_type=pymunk.Body.KINEMATIC) if drive else pymunk.Body(2.0, 0.001666666666666667),
        "block": pymunk.Body(0.6, 0.0002),
        "lever": pymunk.Body(4.0, 0.053333333333333344),
        "link": pymunk.Body(0.8, 0.0014999999999999998),
        "ram": pymunk.Body(15.0, math.inf),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "crank": (
            ((0.0, 0.0), 0.0, (0.0, 0.0), 4.1887902047863905)
            if drive
            else ((0.05, 0.0), 0.0, (0.0, 0.20943951023931953), 4.1887902047863905)
        ),
        "block": ((0.1, 0.0), 1.1071487177940906, (0.0, 0.41887902047863906), 0.8377580409572779),
        "lever": (
            (0.08944271909999157, -0.021114561800016807),
            1.1071487177940906,
            (-0.14986271426220213, 0.07493135713110105),
            0.8377580409572779,
        ),
        "link": (
            (0.2534978932500197, 0.1653854381999832),
            0.10170272609918736,
            (-0.2920783212250765, 0.07493135713110108),
            -1.004274113227485,
        ),
        "ram": ((0.3281103483000563, 0.17300000000000001), 0.0, (-0.28443121392574866, 0.0), 0.0),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (speed / SPEED * vx, speed / SPEED * vy), speed / SPEED * spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "A": pymunk.PivotJoint(bodies["crank"], bodies["block"], (0.1, 0.0) if drive else (0.05, 0.0), (0.0, 0.0)),
        "slot": pymunk.GrooveJoint(
            bodies["lever"], bodies["block"], (-33.35961998958187, 0.0), (32.95961998958187, 0.0), (0.0, 0.0)
        ),
        "slot angle": pymunk.GearJoint(bodies["lever"], bodies["block"], 0.0, 1.0),
        "C": pymunk.PivotJoint(bodies["lever"], bodies["link"], (0.2, 0.0), (-0.075, 0.0)),
        "O4": pymunk.PivotJoint(ground, bodies["lever"], (0.0, -0.2), (-0.2, 0.0)),
        "D": pymunk.PivotJoint(bodies["link"], bodies["ram"], (0.075, 0.0), (0.0, 0.0)),
        "slide": pymunk.GrooveJoint(
            ground,
            bodies["ram"],
            (-33.15961998958187, 0.17300000000000001),
            (33.15961998958187, 0.17300000000000001),
            (0.0, 0.0),
        ),
    }
    if not drive:
        shaft = pymunk.PivotJoint(ground, bodies["crank"], (0.0, 0.0), (-0.05, 0.0))
        constraints = {"O2": shaft, **constraints}
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "C": ("lever", (0.2, 0.0)),
        "D": ("ram", (0.0, 0.0)),
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
