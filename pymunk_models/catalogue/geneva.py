"""Geneva wheel with four slots, while its pin is engaged, scene geneva of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('pin')

Source: the external Geneva wheel (Reuleaux, The Kinematics of Machinery; Norton, Design of Machinery, chapter
2); dimensions are conrod's.

Parameters (SI):

    bodies.driver.points.O.x = 0 m            place of O on driver
    bodies.driver.points.O.y = 0 m            place of O on driver
    bodies.driver.points.pin.x = 0.06 m       place of pin on driver
    bodies.driver.points.pin.y = 0 m          place of pin on driver
    bodies.driver.mass = 1 kg                 mass of driver
    bodies.driver.radius = 0.07 m             radius of the uniform disc driver
    bodies.driver.centre_of_gravity.x = 0 m   centre of the uniform disc driver
    bodies.driver.centre_of_gravity.y = 0 m   centre of the uniform disc driver
    bodies.follower.mass = 0.02 kg            mass of follower
    bodies.follower.inertia = 4e-07 kg m²     inertia of follower about its centre of gravity
    bodies.follower.centre_of_gravity.x = 0 m  centre of gravity of follower
    bodies.follower.centre_of_gravity.y = 0 m  centre of gravity of follower
    bodies.wheel.points.O.x = 0 m             place of O on wheel
    bodies.wheel.points.O.y = 0 m             place of O on wheel
    bodies.wheel.points.rim.x = 0.06 m        place of rim on wheel
    bodies.wheel.points.rim.y = 0 m           place of rim on wheel
    bodies.wheel.mass = 0.8 kg                mass of wheel
    bodies.wheel.radius = 0.06 m              radius of the uniform disc wheel
    bodies.wheel.centre_of_gravity.x = 0 m    centre of the uniform disc wheel
    bodies.wheel.centre_of_gravity.y = 0 m    centre of the uniform disc wheel
    ground.points.O2.x = 0 m                  place of O2 on the ground
    ground.points.O2.y = 0 m                  place of O2 on the ground
    ground.points.O4.x = 0.0848528137 m       place of O4 on the ground
    ground.points.O4.y = 0 m                  place of O4 on the ground
    joints.slot.direction = 0 rad             direction of the line on wheel
    joints.slot.angle = 0 rad                 turn of follower against wheel
    speed = 6.28318531 rad/s                  crank speed; negative is the other sense of rotation
    driver.start = 0 rad                      turn of the crank at crank angle 0
    driver.from = -0.785398163 rad            crank angle at which the pass begins
    driver.to = 0.785398163 rad               crank angle at which the pass ends
    start.wheel.turn = 3.14159265 rad         about the turn of wheel at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = 0 m/s²                        acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): the driver's shaft O2 is at (0, 0) and the
wheel's O4 on the +x axis, y is up; crank angle 0 is where the pin lies between the shafts

Body 'driver' is the crank, driven at SPEED: a kinematic body, whose speed no force changes, and whose angle
`step` writes. The crank angle counts counter-clockwise; it is 0 at time 0. build(speed=...) takes another
speed, at as many steps a revolution; build(drive=False) leaves the crank to its mass, pinned to its shaft.
The input cannot turn fully: it begins at crank angle -45 deg and reaches 45 deg after RUN_STEPS steps. STOP
THERE: beyond, nothing is promised.

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
START_ANGLE = -0.7853981633974483  # rad, crank angle at the start
RUN_STEPS = 250  # of the one pass that the input can make
# The crank's body has the angle CRANK_START + CRANK_SENSE * crank angle.
CRANK, CRANK_START, CRANK_SENSE = "driver", 0.0, 1
GRAVITY = (0.0, 0.0)  # m/s²
ITERATIONS = 1634  # of the solver, in a step
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
        "driver": pymunk.Body(body_type=pymunk.Body.KINEMATIC) if drive else pymunk.Body(1.0, 0.0024500000000000004),
        "follower": pymunk.Body(0.02, 4e-07),
        "wheel": pymunk.Body(0.8, 0.00144),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "driver": ((0.0, 0.0), -0.7853981633974483, (0.0, 0.0), 6.283185307179586),
        "follower": (
            (0.042426406871192854, -0.04242640687119285),
            3.9269908169872414,
            (0.26657297628950194, 0.266572976289502),
            -1.4532785408369296e-15,
        ),
        "wheel": ((0.08485281374238571, 0.0), 3.9269908169872414, (0.0, 0.0), -1.4532785408369296e-15),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (speed / SPEED * vx, speed / SPEED * vy), speed / SPEED * spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "pin": pymunk.PivotJoint(bodies["driver"], bodies["follower"], (0.06, 0.0), (0.0, 0.0)),
        "slot": pymunk.GrooveJoint(
            bodies["wheel"], bodies["follower"], (-8.485281374238571, 0.0), (8.485281374238571, 0.0), (0.0, 0.0)
        ),
        "slot angle": pymunk.GearJoint(bodies["wheel"], bodies["follower"], 0.0, 1.0),
        "O4": pymunk.PivotJoint(ground, bodies["wheel"], (0.08485281374238571, 0.0), (0.0, 0.0)),
    }
    if not drive:
        shaft = pymunk.PivotJoint(ground, bodies["driver"], (0.0, 0.0), (0.0, 0.0))
        constraints = {"O2": shaft, **constraints}
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "pin": ("follower", (0.0, 0.0)),
        "rim": ("wheel", (0.06, 0.0)),
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
