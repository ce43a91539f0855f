"""Four-bar linkage of Example 5.6, in one pass, scene swinging-four-bar of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('A')

Source: document 001 (course module Kinematika & Dinamika Teknik 1, 2021), Example 5.6, pages 39 to 41.

Parameters (SI):

    bodies.coupler.points.A.x = 0 m           place of A on coupler
    bodies.coupler.points.A.y = 0 m           place of A on coupler
    bodies.coupler.points.B.x = 0.21 m        place of B on coupler
    bodies.coupler.points.B.y = 0 m           place of B on coupler
    bodies.coupler.mass = 1.32 kg             mass of coupler
    bodies.crank.points.A.x = 0.11 m          place of A on crank
    bodies.crank.points.A.y = 0 m             place of A on crank
    bodies.crank.points.O.x = 0 m             place of O on crank
    bodies.crank.points.O.y = 0 m             place of O on crank
    bodies.crank.mass = 0.69 kg               mass of crank
    bodies.rocker.points.B.x = 0.145 m        place of B on rocker
    bodies.rocker.points.B.y = 0 m            place of B on rocker
    bodies.rocker.points.O.x = 0 m            place of O on rocker
    bodies.rocker.points.O.y = 0 m            place of O on rocker
    bodies.rocker.mass = 0.91 kg              mass of rocker
    ground.points.O12.x = 0 m                 place of O12 on the ground
    ground.points.O12.y = 0 m                 place of O12 on the ground
    ground.points.O14.x = 0.339724153 m       place of O14 on the ground
    ground.points.O14.y = 0 m                 place of O14 on the ground
    speed = 60 rad/s                          crank speed; negative is the other sense of rotation
    driver.start = 1.05405385 rad             turn of the crank at crank angle 0
    driver.from = -0.174532925 rad            crank angle at which the pass begins
    driver.to = 1.04719755 rad                crank angle at which the pass ends
    start.coupler.B.x = 0.27 m                about where B of coupler is at the start
    start.coupler.B.y = 0.12 m                about where B of coupler is at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = 0 m/s²                        acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): O12 is at (0, 0) and O14 on the +x axis; crank
angle 0 is the printed instant, and it counts clockwise as the document's crank turns

Body 'crank' is the crank, driven at SPEED: a kinematic body, whose speed no force changes, and whose angle
`step` writes. The crank angle counts clockwise; it is 0 at time 0. build(speed=...) takes another speed, at
as many steps a revolution; build(drive=False) leaves the crank to its mass, pinned to its shaft. The input
cannot turn fully: it begins at crank angle -10 deg and reaches 60 deg after RUN_STEPS steps. STOP THERE:
beyond, nothing is promised.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Settings: conrod's preset 'tuned' at 1000 steps a revolution. Written by the export command of conrod, format
pymunk.
"""

import math

import pymunk

SPEED = 60.0  # rad/s, of the crank angle
STEPS_PER_REVOLUTION = 1000
TIMESTEP = 0.00010471975511965977  # s, of a step at SPEED
START_ANGLE = -0.17453292519943295  # rad, crank angle at the start
RUN_STEPS = 194  # of the one pass that the input can make
# The crank's body has the angle CRANK_START + CRANK_SENSE * crank angle.
CRANK, CRANK_START, CRANK_SENSE = "crank", 1.0540538523344571, -1
GRAVITY = (0.0, 0.0)  # m/s²
ITERATIONS = 37  # of the solver, in a step
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
        "crank": pymunk.Body(body_type=pymunk.Body.KINEMATIC) if drive else pymunk.Body(0.69, 0.0006957499999999999),
        "coupler": pymunk.Body(1.32, 0.004850999999999999),
        "rocker": pymunk.Body(0.91, 0.0015943958333333333),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "crank": (
            ((0.0, 0.0), 1.2285867775338901, (0.0, 0.0), -60.0)
            if drive
            else ((0.018456313659340074, 0.05181085297607111), 1.2285867775338901, (3.1086511785642665, -1.1073788195604044), -60.0)
        ),
        "coupler": (
            (0.14184263735550562, 0.10745485004957733),
            0.03651424773569848,
            (6.086005722258391, 1.3794086287072305),
            34.25298698214797,
        ),
        "rocker": (
            (0.2932484000993463, 0.05564399707350621),
            2.266655201204058,
            (2.9773545436941244, 2.486787448267634),
            -53.507201140870826,
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
            bodies["crank"], bodies["coupler"], (0.11, 0.0) if drive else (0.055, 0.0), (-0.105, 0.0)
        ),
        "B": pymunk.PivotJoint(bodies["coupler"], bodies["rocker"], (0.105, 0.0), (0.0725, 0.0)),
        "O14": pymunk.PivotJoint(ground, bodies["rocker"], (0.3397241528063615, 0.0), (-0.0725, 0.0)),
    }
    if not drive:
        shaft = pymunk.PivotJoint(ground, bodies["crank"], (0.0, 0.0), (-0.055, 0.0))
        constraints = {"O12": shaft, **constraints}
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "A": ("crank", (0.11, 0.0) if drive else (0.055, 0.0)),
        "B": ("coupler", (0.105, 0.0)),
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
