"""Crank with two sliders of Example 4.10, in one pass, scene two-slider-linkage of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('A')

Source: document 001 (course module Kinematika & Dinamika Teknik 1, 2021), Example 4.10, pages 28 to 34.

Parameters (SI):

    bodies.crank.points.A.x = 0.14 m          place of A on crank
    bodies.crank.points.A.y = 0 m             place of A on crank
    bodies.crank.points.O12.x = 0 m           place of O12 on crank
    bodies.crank.points.O12.y = 0 m           place of O12 on crank
    bodies.crank.mass = 0.88 kg               mass of crank
    bodies.rod-3.points.A.x = 0.14 m          place of A on rod-3
    bodies.rod-3.points.A.y = 0 m             place of A on rod-3
    bodies.rod-3.points.B.x = 0.27658911 m    place of B on rod-3
    bodies.rod-3.points.B.y = 0.22775606 m    place of B on rod-3
    bodies.rod-3.mass = 1.67 kg               mass of rod-3
    bodies.rod-5.points.B.x = 0.27658911 m    place of B on rod-5
    bodies.rod-5.points.B.y = 0.22775606 m    place of B on rod-5
    bodies.rod-5.points.C.x = 0.152654321 m   place of C on rod-5
    bodies.rod-5.points.C.y = 0.306292633 m   place of C on rod-5
    bodies.rod-5.mass = 0.92 kg               mass of rod-5
    bodies.slider-4.points.B.x = 0.27658911 m  place of B on slider-4
    bodies.slider-4.points.B.y = 0.22775606 m  place of B on slider-4
    bodies.slider-4.mass = 1 kg               mass of slider-4
    bodies.slider-4.inertia = 0.0006 kg m²    inertia of slider-4 about its centre of gravity
    bodies.slider-4.centre_of_gravity.x = 0.27658911 m  centre of gravity of slider-4
    bodies.slider-4.centre_of_gravity.y = 0.22775606 m  centre of gravity of slider-4
    bodies.slider-6.points.C.x = 0.152654321 m  place of C on slider-6
    bodies.slider-6.points.C.y = 0.306292633 m  place of C on slider-6
    bodies.slider-6.mass = 1 kg               mass of slider-6
    bodies.slider-6.inertia = 0.0006 kg m²    inertia of slider-6 about its centre of gravity
    bodies.slider-6.centre_of_gravity.x = 0.152654321 m  centre of gravity of slider-6
    bodies.slider-6.centre_of_gravity.y = 0.306292633 m  centre of gravity of slider-6
    ground.points.B0.x = 0.27658911 m         place of B0 on the ground
    ground.points.B0.y = 0.22775606 m         place of B0 on the ground
    ground.points.C0.x = 0.152654321 m        place of C0 on the ground
    ground.points.C0.y = 0.306292633 m        place of C0 on the ground
    ground.points.O12.x = 0 m                 place of O12 on the ground
    ground.points.O12.y = 0 m                 place of O12 on the ground
    ground.points.O13.x = 0.81 m              place of O13 on the ground
    ground.points.O13.y = 0 m                 place of O13 on the ground
    ground.points.O15.x = 0.092654321 m       place of O15 on the ground
    ground.points.O15.y = 0.306292633 m       place of O15 on the ground
    joints.slide-4.direction = 1.16724936 rad  direction of the line on ground
    joints.slide-4.angle = 0 rad              turn of slider-4 against ground
    joints.slide-6.direction = 1.57079633 rad  direction of the line on ground
    joints.slide-6.angle = 0 rad              turn of slider-6 against ground
    speed = 104.719755 rad/s                  crank speed; negative is the other sense of rotation
    driver.start = 0 rad                      turn of the crank at crank angle 0
    driver.from = -1.57079633 rad             crank angle at which the pass begins
    driver.to = 0.0872664626 rad              crank angle at which the pass ends
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = 0 m/s²                        acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): O12 is at (0, 0) and A on the +x axis at the
printed instant, which is crank angle 0; the crank angle counts counter-clockwise as the document's crank
turns

Body 'crank' is the crank, driven at SPEED: a kinematic body, whose speed no force changes, and whose angle
`step` writes. The crank angle counts counter-clockwise; it is 0 at time 0. build(speed=...) takes another
speed, at as many steps a revolution; build(drive=False) leaves the crank to its mass, pinned to its shaft.
The input cannot turn fully: it begins at crank angle -90 deg and reaches 5 deg after RUN_STEPS steps. STOP
THERE: beyond, nothing is promised.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Settings: conrod's preset 'tuned' at 1000 steps a revolution. Written by the export command of conrod, format
pymunk.
"""

import math

import pymunk

SPEED = 104.71975511965977  # rad/s, of the crank angle
STEPS_PER_REVOLUTION = 1000
TIMESTEP = 6e-05  # s, of a step at SPEED
START_ANGLE = -1.5707963267948966  # rad, crank angle at the start
RUN_STEPS = 263  # of the one pass that the input can make
# The crank's body has the angle CRANK_START + CRANK_SENSE * crank angle.
CRANK, CRANK_START, CRANK_SENSE = "crank", 0.0, 1
GRAVITY = (0.0, 0.0)  # m/s²
ITERATIONS = 305  # of the solver, in a step
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
        "crank": pymunk.Body(body_type=pymunk.Body.KINEMATIC) if drive else pymunk.Body(0.88, 0.0014373333333333336),
        "rod-3": pymunk.Body(1.67, 0.009815342618972255),
        "slider-4": pymunk.Body(1.0, math.inf),
        "rod-5": pymunk.Body(0.92, 0.001650466603355494),
        "slider-6": pymunk.Body(1.0, math.inf),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "crank": (
            ((0.0, 0.0), -1.5707963267948966, (0.0, 0.0), 104.71975511965977)
            if drive
            else ((4.286263797015737e-18, -0.07), -1.5707963267948966, (7.3303828583761845, 4.48856495201751e-16), 104.71975511965977)
        ),
        "rod-3": (
            (0.09802735254781969, -0.05042885418509335),
            -0.2902326029826814,
            (9.664903286985142, 5.467510359811618),
            55.775354711782676,
        ),
        "slider-4": ((0.19605470509563935, 0.03914229162981328), 0.0, (4.669040857217917, 10.935020719623234), 0.0),
        "rod-5": (
            (0.17435451304164684, 0.1092212326899456),
            -0.7056809284290088,
            (2.3345204286089607, 10.212128208857207),
            33.3127240978968,
        ),
        "slider-6": ((0.15265432098765438, 0.17930017375007787), 0.0, (5.810481062011084e-16, 9.489235698091184), 0.0),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (speed / SPEED * vx, speed / SPEED * vy), speed / SPEED * spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "A": pymunk.PivotJoint(
            bodies["crank"],
            bodies["rod-3"],
            (0.14, 0.0) if drive else (0.07, 0.0),
            (-0.06829455523899974, -0.11387803007971735),
        ),
        "B3": pymunk.PivotJoint(
            bodies["rod-3"], bodies["slider-4"], (0.06829455523899974, 0.11387803007971735), (0.0, 0.0)
        ),
        "B5": pymunk.PivotJoint(
            bodies["slider-4"], bodies["rod-5"], (0.0, 0.0), (0.061967394745172544, -0.0392682862343853)
        ),
        "slide-4": pymunk.GrooveJoint(
            ground,
            bodies["slider-4"],
            (-38.99169712390727, -91.7396386850131),
            (39.54487534486327, 92.19515080533198),
            (0.0, 0.0),
        ),
        "C": pymunk.PivotJoint(
            bodies["rod-5"], bodies["slider-6"], (-0.06196739474517257, 0.03926828623438533), (0.0, 0.0)
        ),
        "slide-6": pymunk.GrooveJoint(
            ground,
            bodies["slider-6"],
            (0.15265432098764825, -99.6937073673718),
            (0.15265432098766052, 100.3062926326282),
            (0.0, 0.0),
        ),
    }
    if not drive:
        shaft = pymunk.PivotJoint(ground, bodies["crank"], (0.0, 0.0), (-0.07, 0.0))
        constraints = {"O12": shaft, **constraints}
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "A": ("crank", (0.14, 0.0) if drive else (0.07, 0.0)),
        "B": ("slider-4", (0.0, 0.0)),
        "C": ("slider-6", (0.0, 0.0)),
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
