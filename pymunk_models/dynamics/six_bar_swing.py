"""Six-bar linkage of Example 6.15 in free swing under gravity, scene six-bar-swing of conrod, as a pymunk model.

    model = build()
    step(model)  # as often as needed
    model.position('A')

Source: document 001 (course module Kinematika & Dinamika Teknik 1, 2021), Example 6.15, from page 52 on.

Parameters (SI):

    bodies.coupler.points.A.x = 0.273047619 m  place of A on coupler
    bodies.coupler.points.A.y = -0.45425213 m  place of A on coupler
    bodies.coupler.points.B.x = 0 m           place of B on coupler
    bodies.coupler.points.B.y = 0 m           place of B on coupler
    bodies.coupler.points.E.x = -0.142662308 m  place of E on coupler
    bodies.coupler.points.E.y = -0.125488907 m  place of E on coupler
    bodies.coupler.mass = 7.85 kg             mass of coupler
    bodies.coupler.inertia = 0.243 kg m²      inertia of coupler about its centre of gravity
    bodies.coupler.centre_of_gravity.x = 0.075 m  centre of gravity of coupler
    bodies.coupler.centre_of_gravity.y = -0.229 m  centre of gravity of coupler
    bodies.crank.points.A.x = 0.273047619 m   place of A on crank
    bodies.crank.points.A.y = -0.45425213 m   place of A on crank
    bodies.crank.points.O12.x = 0.132187668 m  place of O12 on crank
    bodies.crank.points.O12.y = -0.596232672 m  place of O12 on crank
    bodies.crank.mass = 1.26 kg               mass of crank
    bodies.rocker.points.C.x = 0.153301887 m  place of C on rocker
    bodies.rocker.points.C.y = 0.24616769 m   place of C on rocker
    bodies.rocker.points.O15.x = -0.333789442 m  place of O15 on rocker
    bodies.rocker.points.O15.y = 0.192856926 m  place of O15 on rocker
    bodies.rocker.mass = 3.08 kg              mass of rocker
    bodies.slider.points.D.x = 0.53 m         place of D on slider
    bodies.slider.points.D.y = 0 m            place of D on slider
    bodies.slider.mass = 1 kg                 mass of slider
    bodies.slider.inertia = 0.0006 kg m²      inertia of slider about its centre of gravity
    bodies.slider.centre_of_gravity.x = 0.53 m  centre of gravity of slider
    bodies.slider.centre_of_gravity.y = 0 m   centre of gravity of slider
    bodies.ternary.points.B.x = 0 m           place of B on ternary
    bodies.ternary.points.B.y = 0 m           place of B on ternary
    bodies.ternary.points.C.x = 0.153301887 m  place of C on ternary
    bodies.ternary.points.C.y = 0.24616769 m  place of C on ternary
    bodies.ternary.points.D.x = 0.53 m        place of D on ternary
    bodies.ternary.points.D.y = 0 m           place of D on ternary
    bodies.ternary.points.X4.x = 0.540943396 m  place of X4 on ternary
    bodies.ternary.points.X4.y = -0.899933465 m  place of X4 on ternary
    bodies.ternary.mass = 7.98 kg             mass of ternary
    bodies.ternary.inertia = 0.247 kg m²      inertia of ternary about its centre of gravity
    bodies.ternary.centre_of_gravity.x = 0.249 m  centre of gravity of ternary
    bodies.ternary.centre_of_gravity.y = 0.072 m  centre of gravity of ternary
    ground.points.D0.x = 0.53 m               place of D0 on the ground
    ground.points.D0.y = 0 m                  place of D0 on the ground
    ground.points.O12.x = 0.132187668 m       place of O12 on the ground
    ground.points.O12.y = -0.596232672 m      place of O12 on the ground
    ground.points.O15.x = -0.333789442 m      place of O15 on the ground
    ground.points.O15.y = 0.192856926 m       place of O15 on the ground
    joints.slide.direction = 0.0121596288 rad  direction of the line on ground
    joints.slide.angle = 0 rad                turn of slider against ground
    speed = 62.8318531 rad/s                  crank speed; negative is the other sense of rotation
    driver.start = 0 rad                      turn of the crank at crank angle 0
    start.crank.rate = 0 rad/s                turn rate of crank where a motion without a drive starts
    gravity.x = 0 m/s²                        acceleration of free fall
    gravity.y = -9.81 m/s²                    acceleration of free fall

Frame (z points to the viewer, angles count counter-clockwise): B is at (0, 0) and D on the +x axis at the
printed instant, which is crank angle 0; the crank angle counts clockwise as the document's crank turns

Nothing holds the speed of body 'crank', the crank: it has its own mass, and moves as weight and loads demand.
Its start, counter-clockwise: crank 0 rad/s.

After a step, positions belong to model.time, and velocities to half a step later: pymunk moves the bodies
first, and then finds velocities that fit the joints.

Settings: conrod's preset 'tuned' at 0.0001 s a step. Written by the export command of conrod, format pymunk.
"""

import math

import pymunk

CRANK = "crank"
TIMESTEP = 0.0001  # s
RUN_STEPS = 2000
GRAVITY = (0.0, -9.81)  # m/s²
ITERATIONS = 364  # of the solver, in a step
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
        "crank": pymunk.Body(1.26, 0.004200000000000001),
        "coupler": pymunk.Body(7.85, 0.243),
        "ternary": pymunk.Body(7.98, 0.247),
        "rocker": pymunk.Body(3.08, 0.061625666666666655),
        "slider": pymunk.Body(1.0, math.inf),
    }
    # Centre of gravity [m], angle [rad], its velocity [m/s], angular velocity [rad/s].
    start = {
        "crank": ((0.2026176436069869, -0.525242401013971), -2.943263774769001e-17, (0.0, 0.0), 0.0),
        "coupler": ((0.075, -0.22899999999999998), -2.6885049080188846e-19, (0.0, 0.0), 0.0),
        "ternary": ((0.249, 0.07200000000000001), 1.2079252866136224e-17, (0.0, 0.0), 0.0),
        "rocker": ((-0.09024377756221673, 0.21951230810013214), 1.1579266508841092e-17, (0.0, 0.0), 0.0),
        "slider": ((0.53, -4.306278688425196e-21), 0.0, (0.0, 0.0), 0.0),
    }
    for name, (position, angle, (vx, vy), spin) in start.items():
        body = bodies[name]
        body.position, body.angle = position, angle
        body.velocity, body.angular_velocity = (vx, vy), spin
    ground = space.static_body
    # Anchors [m] in each body's frame, whose origin is its centre of gravity.
    constraints = {
        "O12": pymunk.PivotJoint(
            ground,
            bodies["crank"],
            (0.1321876681663548, -0.5962326718926764),
            (-0.07042997544063209, -0.07099027087870535),
        ),
        "A": pymunk.PivotJoint(
            bodies["crank"],
            bodies["coupler"],
            (0.07042997544063209, 0.07099027087870535),
            (0.19804761904761897, -0.22525213013526565),
        ),
        "B": pymunk.PivotJoint(bodies["coupler"], bodies["ternary"], (-0.075, 0.229), (-0.249, -0.072)),
        "C": pymunk.PivotJoint(
            bodies["ternary"],
            bodies["rocker"],
            (-0.09569811320754715, 0.17416768980894703),
            (0.24354566435466957, 0.0266553817088149),
        ),
        "D": pymunk.PivotJoint(bodies["ternary"], bodies["slider"], (0.281, -0.072), (0.0, 0.0)),
        "O15": pymunk.PivotJoint(
            ground,
            bodies["rocker"],
            (-0.3337894419168863, 0.19285692639131724),
            (-0.24354566435466957, -0.0266553817088149),
        ),
        "slide": pymunk.GrooveJoint(
            ground,
            bodies["slider"],
            (-99.46260726247986, -1.215932914046104),
            (100.52260726247987, 1.215932914046104),
            (0.0, 0.0),
        ),
    }
    for constraint in constraints.values():
        constraint.error_bias = ERROR_BIAS
        constraint.collide_bodies = False
    space.add(*bodies.values(), *constraints.values())
    points = {
        "A": ("crank", (0.07042997544063209, 0.07099027087870535)),
        "B": ("coupler", (-0.075, 0.229)),
        "C": ("ternary", (-0.09569811320754715, 0.17416768980894703)),
        "D": ("slider", (0.0, 0.0)),
        "E": ("coupler", (-0.21766230794897462, 0.10351109255925475)),
        "X4": ("ternary", (0.29194339622641496, -0.9719334653623187)),
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
    """Run 0.2 s, and print how far each observed point travels."""
    model = build()
    paths = {point: [model.position(point)] for point in model.points}
    for _ in range(RUN_STEPS):
        step(model)
        for point, path in paths.items():
            path.append(model.position(point))
    for point, path in paths.items():
        print(f"{point}: travels {1e3 * travel(path):.4f} mm in 0.2 s")


if __name__ == "__main__":
    main()
