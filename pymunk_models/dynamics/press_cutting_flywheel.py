"""Shear press under a cutting force, with a flywheel, scene press-cutting-flywheel of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('A')

Source: document 000 (analysis of a steel-plate shear press), sections IV.1 and IV.2; the cut, the motor and
the masses are conrod's.

Parameters (SI):

    bodies.crank.points.P.x = 0.0325 m        place of P on crank
    bodies.crank.points.P.y = 0 m             place of P on crank
    bodies.crank.mass = 305 kg                mass of crank
    bodies.crank.inertia = 30.5 kg m²         inertia of crank about its centre of gravity
    bodies.crank.centre_of_gravity.x = 0 m    centre of gravity of crank
    bodies.crank.centre_of_gravity.y = 0 m    centre of gravity of crank
    bodies.rod.points.A.x = 0.39 m            place of A on rod
    bodies.rod.points.A.y = 0 m               place of A on rod
    bodies.rod.points.G.x = 0.13 m            place of G on rod
    bodies.rod.points.G.y = 0 m               place of G on rod
    bodies.rod.points.P.x = 0 m               place of P on rod
    bodies.rod.points.P.y = 0 m               place of P on rod
    bodies.rod.mass = 8 kg                    mass of rod
    bodies.rod.inertia = 0.12 kg m²           inertia of rod about its centre of gravity
    bodies.rod.centre_of_gravity.x = 0.13 m   centre of gravity of rod
    bodies.rod.centre_of_gravity.y = 0 m      centre of gravity of rod
    bodies.slider.mass = 60 kg                mass of slider
    bodies.slider.inertia = 0.6 kg m²         inertia of slider about its centre of gravity
    bodies.slider.centre_of_gravity.x = 0 m   centre of gravity of slider
    bodies.slider.centre_of_gravity.y = 0 m   centre of gravity of slider
    ground.points.O.x = 0 m                   place of O on the ground
    ground.points.O.y = 0 m                   place of O on the ground
    joints.slide.direction = 1.57079633 rad   direction of the line on ground
    joints.slide.angle = 0 rad                turn of slider against ground
    speed = 5.75 rad/s                        crank speed; negative is the other sense of rotation
    driver.start = 1.57079633 rad             turn of the crank at crank angle 0
    start.rod.turn = 1.57079633 rad           about the turn of rod at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall
    forces.cut.direction = 1.57079633 rad     direction in the document's frame that the force cut acts along
    forces.cut.peak = 10000 N                 peak of the force cut
    forces.cut.begin = 0.375 m                where along its direction the force cut begins
    forces.cut.end = 0.395 m                  where along its direction the force cut ends
    torques.motor.stall = -400 N m            torque motor at rest
    torques.motor.idle = -6 rad/s             rate of turn at which the torque motor is 0

Frame (z points to the viewer, angles count counter-clockwise): shaft at the origin, x right, y up; the crank
angle counts clockwise from the upward vertical; the slider A moves on x = 0 above the shaft

Nothing holds the speed of body 'crank', the crank: it has its own mass, and moves as weight and loads demand.
Its start, counter-clockwise: crank -5.75 rad/s.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Loads, applied by `step`: forces.cut (StrokePulse(peak=10000.0, start=0.375, stop=0.395, sense=-1)),
torques.motor (SpeedLine(size=-400.0, idle=-6.0)).

Settings: conrod's preset 'tuned' at 0.00109273 s a step. Written by the export command of conrod, format
pymunk.
"""

import math

import pymunk

CRANK = "crank"
TIMESTEP = 0.0010927278795094932  # s
RUN_STEPS = 2000
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 677  # of the solver, in a step
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
        self.known = None  # instant and rates of the step before

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
        "crank": pymunk.Body(305.0, 30.5),
        "rod": pymunk.Body(8.0, 0.12),
        "slider": pymunk.Body(60.0, math.inf),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "crank": ((0.0, 0.0), 1.570796326794897, (0.0, 0.0), -5.749999999999997),
        "rod": (
            (-4.822327325013484e-17, 0.1625),
            1.570796326794897,
            (0.12458333333333338, -4.0420392989323187e-17),
            0.4791666666666666,
        ),
        "slider": (
            (2.587066363198783e-17, 0.42250000000000015),
            0.0,
            (8.934575586118923e-34, 5.211810257625747e-18),
            0.0,
        ),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (vx, vy), spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "shaft": pymunk.PivotJoint(ground, bodies["crank"], (0.0, 0.0), (0.0, 0.0)),
        "crank-pin": pymunk.PivotJoint(bodies["crank"], bodies["rod"], (0.0325, 0.0), (-0.13, 0.0)),
        "slider-pin": pymunk.PivotJoint(bodies["rod"], bodies["slider"], (0.26, 0.0), (0.0, 0.0)),
        "slide": pymunk.GrooveJoint(
            ground, bodies["slider"], (-2.5870663631987836e-15, -42.25), (2.5870663631987836e-15, 42.25), (0.0, 0.0)
        ),
    }
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "A": ("slider", (0.0, 0.0)),
        "G": ("rod", (0.0, 0.0)),
    }
    return Model(space, bodies, constraints, points)


def step(model):
    """Advance a model by one time step."""
    if model.steps == 0:
        _start_between_steps(model)
    _apply_loads(model)
    model.space.step(model.timestep)
    model.steps += 1


def _start_between_steps(model):
    """Advance the velocities by half a step: pymunk's belong to the middle between two steps."""
    _apply_loads(model, at_start=True)
    for body in model.bodies.values():
        body.position -= 0.5 * model.timestep * body.velocity
        body.angle -= 0.5 * model.timestep * body.angular_velocity
    model.space.step(0.5 * model.timestep)


def _apply_loads(model, at_start=False):
    """Apply all loads, at the instant to which the change of velocity in the step belongs; a step clears forces."""
    places = {name: (*body.position, body.angle) for name, body in model.bodies.items()}
    rates = {name: (*body.velocity, body.angular_velocity) for name, body in model.bodies.items()}
    if at_start:
        instant, expected, model.known = 0.0, rates, (0.0, rates)
    else:
        # A velocity belongs to half a step after its positions; rates are extrapolated by their last difference.
        now = model.time + 0.5 * model.timestep
        instant, expected = model.time + 0.5 * model.timestep + 0.5 * model.timestep, rates
        if model.known is not None and now > model.known[0]:
            share = (instant - now) / (now - model.known[0])
            expected = {
                name: tuple(v + share * (v - before) for v, before in zip(rate, model.known[1][name]))
                for name, rate in rates.items()
            }
        model.known = now, rates
        way = instant - model.time
        places = {name: tuple(x + way * v for x, v in zip(place, rates[name])) for name, place in places.items()}
    state = places, expected
    forces = {name: (0.0, 0.0, 0.0) for name in model.bodies}
    # forces.cut
    value, rate, gradient = _displacement(state, ('slider', (0.0, 0.0)), 1.5707963267948966)
    _add_force(forces, gradient, 10000.0 * _pulse(value, 0.375, 0.395) if rate * -1 > 0.0 else 0.0)
    # torques.motor
    value, rate, gradient = _turn(state, 'ground', 'crank')
    _add_force(forces, gradient, -400.0 * (1.0 - rate / -6.0))
    for name, (x, y, torque) in forces.items():
        model.bodies[name].force, model.bodies[name].torque = (x, y), torque


def _add_force(forces, gradient, force):
    """Add a force along a coordinate, with the coordinate's gradient, to forces [N] and moments [N m] of bodies."""
    for body, parts in gradient:
        if body in forces:
            forces[body] = tuple(total + force * part for total, part in zip(forces[body], parts))


def _point(state, body, place):
    """Position [m], velocity [m/s] and arm from the centre of gravity [m] of a point of a body, or of the ground."""
    x, y = place
    if body not in state[0]:
        return x, y, 0.0, 0.0, x, y
    (cx, cy, angle), (vx, vy, spin) = state[0][body], state[1][body]
    c, s = math.cos(angle), math.sin(angle)
    rx, ry = c * x - s * y, s * x + c * y
    return cx + rx, cy + ry, vx - spin * ry, vy + spin * rx, rx, ry


def _turn(state, a, b):
    """Angle [rad] of body b against body a, with its rate and its gradient."""
    (angle_a, spin_a), (angle_b, spin_b) = (
        (state[0][name][2], state[1][name][2]) if name in state[0] else (0.0, 0.0) for name in (a, b)
    )
    return angle_b - angle_a, spin_b - spin_a, [(b, (0.0, 0.0, 1.0)), (a, (0.0, 0.0, -1.0))]


def _displacement(state, point, direction):
    """Position [m] of a point along a direction [rad], with its rate and its gradient."""
    x, y, vx, vy, rx, ry = _point(state, *point)
    ux, uy = math.cos(direction), math.sin(direction)
    return x * ux + y * uy, vx * ux + vy * uy, [(point[0], (ux, uy, rx * uy - ry * ux))]


def _pulse(x, start, stop):
    """Squared half wave between start and stop, 1 in their middle."""
    wave = math.sin(math.pi * min(max((x - start) / (stop - start), 0.0), 1.0))
    return wave * wave


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
    """Run 2.18546 s, and print how far each observed point travels."""
    model = build()
    paths = {point: [model.position(point)] for point in model.points}
    for _ in range(RUN_STEPS):
        step(model)
        for point, path in paths.items():
            path.append(model.position(point))
    for point, path in paths.items():
        print(f"{point}: travels {1e3 * travel(path):.4f} mm in 2.18546 s")


if __name__ == "__main__":
    main()
