"""Wheel rolling on a convex track, Figure 6.12, scene rolling-on-convex of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('C')

Source: document 001 (course module Kinematika & Dinamika Teknik 1, 2021), Figure 6.12, pages 50 to 52.

Parameters (SI):

    bodies.arm.points.C.x = 0.2 m             place of C on arm
    bodies.arm.points.C.y = 0 m               place of C on arm
    bodies.arm.points.O.x = 0 m               place of O on arm
    bodies.arm.points.O.y = 0 m               place of O on arm
    bodies.arm.mass = 1.26 kg                 mass of arm
    bodies.wheel.points.C.x = 0 m             place of C on wheel
    bodies.wheel.points.C.y = 0 m             place of C on wheel
    bodies.wheel.points.D.x = 0 m             place of D on wheel
    bodies.wheel.points.D.y = -0.05 m         place of D on wheel
    bodies.wheel.mass = 1.23 kg               mass of wheel
    bodies.wheel.radius = 0.05 m              radius of the uniform disc wheel
    bodies.wheel.centre_of_gravity.x = 0 m    centre of the uniform disc wheel
    bodies.wheel.centre_of_gravity.y = 0 m    centre of the uniform disc wheel
    ground.points.O.x = 0 m                   place of O on the ground
    ground.points.O.y = 0 m                   place of O on the ground
    joints.track.radii.0 = 0.05 m             pitch radius of wheel
    joints.track.radii.1 = 0.15 m             pitch radius of ground
    speed = 6.28318531 rad/s                  crank speed; negative is the other sense of rotation
    driver.start = 1.57079633 rad             turn of the crank at crank angle 0
    start.wheel.turn = 0 rad                  about the turn of wheel at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): the track's centre O is at (0, 0), y is up; at
crank angle 0 the wheel stands on top of the track and touches it with its point D; the arm's angle counts
counter-clockwise from there

Body 'arm' is the crank, driven at SPEED: a kinematic body, whose speed no force changes, and whose angle
`step` writes. The crank angle counts counter-clockwise; it is 0 at time 0. build(speed=...) takes another
speed, at as many steps a revolution; build(drive=False) leaves the crank to its mass, pinned to its shaft.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Settings: conrod's preset 'tuned' at 1000 steps a revolution. Written by the export command of conrod, format
pymunk.
"""

import math

import pymunk

SPEED = 6.283185307179586  # rad/s, of the crank angle
STEPS_PER_REVOLUTION = 1000
TIMESTEP = 0.001  # s, of a step at SPEED
START_ANGLE = 0.0  # rad, crank angle at the start
RUN_STEPS = 2 * STEPS_PER_REVOLUTION
# The crank's body has the angle CRANK_START + CRANK_SENSE * crank angle.
CRANK, CRANK_START, CRANK_SENSE = "arm", 1.5707963267948966, 1
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 10  # of the solver, in a step
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
        "arm": pymunk.Body(body_type=pymunk.Body.KINEMATIC) if drive else pymunk.Body(1.26, 0.004200000000000001),
        "wheel": pymunk.Body(1.23, 0.0015375000000000002),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "arm": (
            ((0.0, 0.0), 1.5707963267948966, (0.0, 0.0), 6.283185307179586)
            if drive
            else ((6.123233995736766e-18, 0.1), 1.5707963267948966, (-0.6283185307179586, 3.84734138744358e-17), 6.283185307179586)
        ),
        "wheel": ((1.2246467991473533e-17, 0.2), 0.0, (-1.2566370614359172, 7.69468277488716e-17), 25.13274122871834),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (speed / SPEED * vx, speed / SPEED * vy), speed / SPEED * spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "C": pymunk.PivotJoint(bodies["arm"], bodies["wheel"], (0.2, 0.0) if drive else (0.1, 0.0), (0.0, 0.0)),
        "track": pymunk.GearJoint(bodies["wheel"], bodies["arm"], 6.283185307179586, 4.0),
    }
    if not drive:
        shaft = pymunk.PivotJoint(ground, bodies["arm"], (0.0, 0.0), (-0.1, 0.0))
        constraints = {"O": shaft, **constraints}
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "C": ("arm", (0.2, 0.0) if drive else (0.1, 0.0)),
        "D": ("wheel", (0.0, -0.05)),
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
