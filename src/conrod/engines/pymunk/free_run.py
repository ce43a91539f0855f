"""Free and torque-driven motion in pymunk: all bodies are dynamic, and nothing is written after the start but loads.

Positions belong to t_n, velocities to t_n + h / 2 (see `Staggered`). A velocity given at t = 0 and stepped with as it
is would be early by half a step, for good, since nothing but the start prescribes it: order 1. So the bodies are put
back by half a step, x_0 - h v_0 / 2, and the first step has half the length: it ends in the given poses, with the
velocities of t = h / 2. Reported rates are means of those before and after. Contact is corrected by velocities of its
own, and its velocities belong to t_n as they are.

What is left is of order 2, energy is lost with it. Where branches of a linkage meet its joints are redundant, and the
iteration slow: what it leaves there costs energy at every passage, the more the more steps a passage has. Two four-bars
in a row of 1 m, tuned, stay on their branch through the ten passages of ten seconds, but are off by 1.1e-2 of their
travel with h = 2.5 ms, 0.7e-2 with 1.25 ms, and 0.7 with 0.3 ms; with 64 times the iterations by 0.6e-2, 1.0e-3 and
2.4e-4 (0.6 ms).
"""

from __future__ import annotations

import numpy as np

from conrod.engines.centres import body_states
from conrod.engines.engine import PIECE
from conrod.engines.pymunk.gears import gears_refusal
from conrod.engines.pymunk.loads import Pushes
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.pymunk.space import Build, build_free
from conrod.engines.pymunk.stepping import advance_free, state
from conrod.engines.tracks import FreeRun, Pace
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism


def free_run(
    mechanism: Mechanism, preset: str, timestep: float, steps: int, poses: Array, rates: Array, pace: Pace,
    every: int = 1,
) -> FreeRun:  # fmt: skip
    """So many steps from exact poses and rates (3 n,), sampled at every so-many-th; no rule here asks for the pace.

    Raises:
        InvalidInput: there is no such preset, or pymunk cannot have a joint of the mechanism; says why.
    """
    settings = PymunkSettings.free(mechanism, preset, timestep)
    if reason := gears_refusal(mechanism):
        raise InvalidInput(f"{mechanism.name}: {reason}")
    made = build_free(mechanism, settings, poses)
    made.place(poses, rates)
    h, in_step = settings.timestep, not mechanism.cam_contacts
    places, speeds = ([values.copy()] for values in state(made))
    pushes = Pushes(made, h, 0.5 * h if in_step else 0.0) if mechanism.loads else None
    before = _half_step(made, h, pushes) if in_step else speeds[0][0]
    length, done = max(1, PIECE // every) * every, 0
    while done < steps:
        count = min(length, steps - done)
        loading = None if pushes is None else (pushes.give, np.asarray(h * np.arange(done, done + count), dtype=float))
        after = advance_free(made, h, count, loading)
        earlier = np.vstack([before[None], after[1][:-1]])
        # A record is due after step k, counted from 1, where it divides.
        due = slice(every - 1, None, every)
        places.append(after[0][due])
        speeds.append(0.5 * (earlier[due] + after[1][due]) if in_step else after[1][due])
        before, done = after[1][-1], done + count
    with np.errstate(all="ignore"):
        reported_poses, reported_rates = body_states(mechanism, np.vstack(places), np.vstack(speeds))
        reported_poses[0], reported_rates[0] = poses, rates
    times = np.asarray(h * (every * np.arange(len(reported_poses))), dtype=float)
    return FreeRun.judged(mechanism, times, (reported_poses, reported_rates))


def _half_step(made: Build, h: float, pushes: Pushes | None) -> Array:
    """Bring the velocities to h / 2, with the bodies where they are; returns the velocities (3 n,)."""
    if pushes is None:
        for body, force in made.pushed:
            body.force = force
    else:
        pushes.as_they_are(0.0)
    for body in made.bodies:
        body.position -= 0.5 * h * body.velocity
        body.angle -= 0.5 * h * body.angular_velocity
    made.space.step(0.5 * h)
    return np.asarray(state(made)[1][0])
