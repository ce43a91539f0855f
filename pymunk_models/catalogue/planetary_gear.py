"""Planetary gear, driven at the sun, scene planetary-gear of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('arm')

Source: the simple epicyclic train with a fixed ring (Willis' formula; Norton, Design of Machinery, chapter
9); dimensions are conrod's.

Parameters (SI):

    bodies.carrier.points.O.x = 0 m           place of O on carrier
    bodies.carrier.points.O.y = 0 m           place of O on carrier
    bodies.carrier.points.planet.x = 0.035 m  place of planet on carrier
    bodies.carrier.points.planet.y = 0 m      place of planet on carrier
    bodies.carrier.mass = 0.6 kg              mass of carrier
    bodies.carrier.radius = 0.04 m            radius of the uniform disc carrier
    bodies.carrier.centre_of_gravity.x = 0 m  centre of the uniform disc carrier
    bodies.carrier.centre_of_gravity.y = 0 m  centre of the uniform disc carrier
    bodies.planet.points.mark.x = 0.015 m     place of mark on planet
    bodies.planet.points.mark.y = 0 m         place of mark on planet
    bodies.planet.mass = 0.1 kg               mass of planet
    bodies.planet.radius = 0.015 m            radius of the uniform disc planet
    bodies.planet.centre_of_gravity.x = 0 m   centre of the uniform disc planet
    bodies.planet.centre_of_gravity.y = 0 m   centre of the uniform disc planet
    bodies.sun.mass = 0.2 kg                  mass of sun
    bodies.sun.radius = 0.02 m                radius of the uniform disc sun
    bodies.sun.centre_of_gravity.x = 0 m      centre of the uniform disc sun
    bodies.sun.centre_of_gravity.y = 0 m      centre of the uniform disc sun
    ground.points.O.x = 0 m                   place of O on the ground
    ground.points.O.y = 0 m                   place of O on the ground
    joints.ring-mesh.radii.0 = 0.015 m        pitch radius of planet
    joints.ring-mesh.radii.1 = 0.05 m         pitch radius of ground
    joints.sun-mesh.radii.0 = 0.02 m          pitch radius of sun
    joints.sun-mesh.radii.1 = 0.015 m         pitch radius of planet
    speed = 12.5663706 rad/s                  crank speed; negative is the other sense of rotation
    driver.start = 0 rad                      turn of the crank at crank angle 0
    start.carrier.turn = 0 rad                about the turn of carrier at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): the shafts are at (0, 0), x and y as drawn;
the planet stands on the +x axis at crank angle 0

Body 'sun' is the crank, driven at SPEED: a kinematic body, whose speed no force changes, and whose angle
`step` writes. The crank angle counts counter-clockwise; it is 0 at time 0. build(speed=...) takes another
speed, at as many steps a revolution; build(drive=False) leaves the crank to its mass, pinned to its shaft.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Settings: conrod's preset 'tuned' at 1000 steps a revolution. Written by the export command of conrod, format
pymunk.
"""

import math

import pymunk

SPEED = 12.566370614359172  # rad/s, of the crank angle
STEPS_PER_REVOLUTION = 1000
TIMESTEP = 0.0005  # s, of a step at SPEED
START_ANGLE = 0.0  # rad, crank angle at the start
RUN_STEPS = 2 * STEPS_PER_REVOLUTION
# The crank's body has the angle CRANK_START + CRANK_SENSE * crank angle.
CRANK, CRANK_START, CRANK_SENSE = "sun", 0.0, 1
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 123  # of the solver, in a step
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
        "sun": pymunk.Body(body_type=pymunk.Body.KINEMATIC) if drive else pymunk.Body(0.2, 4e-05),
        "planet": pymunk.Body(0.1, 1.125e-05),
        "carrier": pymunk.Body(0.6, 0.00048),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "sun": ((0.0, 0.0), 0.0, (0.0, 0.0), 12.566370614359172),
        "planet": ((0.035, 0.0), 0.0, (0.0, 0.12566370614359174), -8.377580409572783),
        "carrier": ((0.0, 0.0), 0.0, (0.0, 0.0), 3.5903916041026207),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (speed / SPEED * vx, speed / SPEED * vy), speed / SPEED * spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "planet-pin": pymunk.PivotJoint(bodies["planet"], bodies["carrier"], (0.0, 0.0), (0.035, 0.0)),
        "carrier-shaft": pymunk.PivotJoint(ground, bodies["carrier"], (0.0, 0.0), (0.0, 0.0)),
        "sun-mesh": pymunk.GearJoint(bodies["planet"], bodies["sun"], 0.0, -0.6666666666666667),
        "ring-mesh": pymunk.GearJoint(bodies["carrier"], bodies["sun"], 0.0, 0.2857142857142857),
    }
    if not drive:
        shaft = pymunk.PivotJoint(ground, bodies["sun"], (0.0, 0.0), (0.0, 0.0))
        constraints = {"sun-shaft": shaft, **constraints}
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "arm": ("carrier", (0.035, 0.0)),
        "mark": ("planet", (0.015, 0.0)),
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
