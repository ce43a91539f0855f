"""Power hacksaw coasting down with friction in its slide, scene saw-coasting of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('C')

Source: document 002 (kinematic simulation of a power hacksaw by complex numbers), section 3; friction and
masses are conrod's.

Parameters (SI):

    bodies.crank.points.P.x = 0.1 m           place of P on crank
    bodies.crank.points.P.y = 0 m             place of P on crank
    bodies.crank.mass = 4 kg                  mass of crank
    bodies.crank.inertia = 0.02 kg m²         inertia of crank about its centre of gravity
    bodies.crank.centre_of_gravity.x = 0 m    centre of gravity of crank
    bodies.crank.centre_of_gravity.y = 0 m    centre of gravity of crank
    bodies.rod.points.C.x = 0.3 m             place of C on rod
    bodies.rod.points.C.y = 0 m               place of C on rod
    bodies.rod.points.M.x = 0.15 m            place of M on rod
    bodies.rod.points.M.y = 0 m               place of M on rod
    bodies.rod.points.P.x = 0 m               place of P on rod
    bodies.rod.points.P.y = 0 m               place of P on rod
    bodies.rod.mass = 1.5 kg                  mass of rod
    bodies.slider.mass = 6 kg                 mass of slider
    bodies.slider.inertia = 0.06 kg m²        inertia of slider about its centre of gravity
    bodies.slider.centre_of_gravity.x = 0 m   centre of gravity of slider
    bodies.slider.centre_of_gravity.y = 0 m   centre of gravity of slider
    ground.points.C.x = 0 m                   place of C on the ground
    ground.points.C.y = 0 m                   place of C on the ground
    ground.points.O.x = 0.18618176 m          place of O on the ground
    ground.points.O.y = -0.09 m               place of O on the ground
    joints.slide.direction = 0 rad            direction of the line on ground
    joints.slide.angle = 0 rad                turn of slider against ground
    speed = 52.3598776 rad/s                  crank speed; negative is the other sense of rotation
    driver.start = 0 rad                      turn of the crank at crank angle 0
    start.rod.C.x = 0 m                       about where C of rod is at the start
    start.rod.C.y = 0 m                       about where C of rod is at the start
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall
    forces.friction.direction = 0 rad         direction in the document's frame that the force friction acts along
    forces.friction.force = 30 N              sliding friction friction
    forces.friction.creep = 0.02 m/s          speed below which the friction friction has not come up

Frame (z points to the viewer, angles count counter-clockwise): the slider C is at (0, 0) for crank angle 0
and moves along x; y is up; the shaft is at (sqrt(l^2 - e^2) - r, -e)

Nothing holds the speed of body 'crank', the crank: it has its own mass, and moves as weight and loads demand.
Its start, counter-clockwise: crank 52.3598776 rad/s.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Loads, applied by `step`: forces.friction (Friction(size=30.0, creep=0.02)).

Settings: conrod's preset 'tuned' at 0.00012 s a step. Written by the export command of conrod, format pymunk.
"""

import math

import pymunk

CRANK = "crank"
TIMESTEP = 0.00012  # s
RUN_STEPS = 2000
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 272  # of the solver, in a step
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
        "crank": pymunk.Body(4.0, 0.02),
        "rod": pymunk.Body(1.5, 0.011250000000000001),
        "slider": pymunk.Body(6.0, math.inf),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "crank": ((0.1861817604250837, -0.09), 8.820996743539899e-17, (0.0, 0.0), 52.35987755982988),
        "rod": (
            (0.14309088021254174, -0.04500000000000005),
            2.836899999574396,
            (-0.8233209854787885, 2.6179938779914966),
            18.296021899528625,
        ),
        "slider": ((3.710508787655525e-17, 0.0), 0.0, (-1.6466419709575766, 0.0), 0.0),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (vx, vy), spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "shaft": pymunk.PivotJoint(ground, bodies["crank"], (0.1861817604250837, -0.09), (0.0, 0.0)),
        "crank-pin": pymunk.PivotJoint(bodies["crank"], bodies["rod"], (0.1, 0.0), (-0.15, 0.0)),
        "slider-pin": pymunk.PivotJoint(bodies["rod"], bodies["slider"], (0.15, 0.0), (0.0, 0.0)),
        "slide": pymunk.GrooveJoint(
            ground, bodies["slider"], (-28.61817604250837, 0.0), (28.61817604250837, 0.0), (0.0, 0.0)
        ),
    }
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "C": ("slider", (0.0, 0.0)),
        "M": ("rod", (0.0, 0.0)),
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
    # forces.friction
    value, rate, gradient = _displacement(state, ('slider', (0.0, 0.0)), 0.0)
    _add_force(forces, gradient, -30.0 * math.tanh(rate / 0.02))
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


def _displacement(state, point, direction):
    """Position [m] of a point along a direction [rad], with its rate and its gradient."""
    x, y, vx, vy, rx, ry = _point(state, *point)
    ux, uy = math.cos(direction), math.sin(direction)
    return x * ux + y * uy, vx * ux + vy * uy, [(point[0], (ux, uy, rx * uy - ry * ux))]


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
    """Run 0.24 s, and print how far each observed point travels."""
    model = build()
    paths = {point: [model.position(point)] for point in model.points}
    for _ in range(RUN_STEPS):
        step(model)
        for point, path in paths.items():
            path.append(model.position(point))
    for point, path in paths.items():
        print(f"{point}: travels {1e3 * travel(path):.4f} mm in 0.24 s")


if __name__ == "__main__":
    main()
