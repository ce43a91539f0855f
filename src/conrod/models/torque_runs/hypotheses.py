"""What may be behind a run's differences from the exact motion: changes of torque, stamps, start, masses and loads."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import numpy as np

from conrod.errors import InvalidInput
from conrod.mechanism.loads import Friction, Load, Sampled, Viscous
from conrod.mechanism.units import RPM
from conrod.models.tables.columns import CRANK_SPEED
from conrod.models.torque_runs.exact import CrankStart, Values
from conrod.models.torque_runs.question import RunQuestion
from conrod.models.torque_runs.torque import WAY_WORDS, WAYS, Torque, scale_torque, shift_torque

MAX_FIT_BODIES = 8  # of a machine whose masses are doubted one by one
GRAVITY = 9.81  # [m/s^2]
CREEP_SHARE = 1e-3  # of the crank's largest speed, below which dry friction has not come up

# Kind of a cause; its words, and what it predicts at the rows, for its size p; a first size, None for a cause without.
Hypothesis: TypeAlias = tuple[str, Callable[[float], str], Callable[[float], Values], float | None]


def run_hypotheses(question: RunQuestion) -> Iterator[Hypothesis]:
    """Yield possible causes of a run's differences from the exact motion, the simplest first."""
    yield from _torque_hypotheses(question)
    yield from _stamp_hypotheses(question)
    yield from _start_hypotheses(question)
    yield from _mass_hypotheses(question)
    yield from _load_hypotheses(question)


def _torque_hypotheses(question: RunQuestion) -> Iterator[Hypothesis]:
    """Another size of the torque, or another way from row to row."""
    torque = question.torque
    if _peak(torque) > 0.0:
        yield (
            "torque",
            lambda size: _torque_words(question, size),
            lambda size: question.predict(torque=replace(torque, law=scale_torque(torque.law, 1.0 + size))),
            0.01,
        )
    if isinstance(law := torque.law, Sampled):
        for way in WAYS:
            if way != law.between:
                other = replace(torque, law=Sampled(law.times, law.sizes, way))
                words = f"the torque is {WAY_WORDS[way]}: --torque ...:{way} says so"
                yield _without_size("torque between rows", words, partial(question.predict, torque=other))
        step = float(np.median(np.diff(law.times)))
        yield (
            "torque delay",
            lambda size: f"the torque acts {_steps_words(size, step)} than its time says",
            lambda size: question.predict(torque=replace(torque, law=shift_torque(law, size))),
            0.5 * step,
        )


def _without_size(kind: str, words: str, predict: Callable[[], Values]) -> Hypothesis:
    """A cause that is there or is not."""
    return kind, lambda _: words, lambda _: predict(), None


def _torque_words(question: RunQuestion, size: float) -> str:
    """Name a factor of the torque, and what would have the same effect."""
    words, law = [f"the torque is {1.0 + size:.6g} times the given one"], question.torque.law
    if size > -1.0 and not question.scene.kinematics.mechanism.loads:
        words.append(f"all masses and inertias are {1.0 / (1.0 + size):.6g} times the machine's")
    if -1.0 < size < 0.0 and not isinstance(law, Sampled):
        words.append(f"the crank has a dry friction of {-size * _peak(question.torque):.4g} N m")
    return ", or ".join(words)


def _stamp_hypotheses(question: RunQuestion) -> Iterator[Hypothesis]:
    """Rows that belong to another time, all columns or velocities alone."""
    step = question.row_distance

    def later(size: float, among: Callable[[str], bool]) -> Values:
        moved, base = question.predict(later=size), question.predict()
        return {name: moved[name] if among(name) else own for name, own in base.items()}

    yield (
        "time",
        lambda size: f"each row belongs {_steps_words(size, step)} than its time says",
        lambda size: later(size, lambda _: True),
        0.5 * step,
    )
    yield (
        "velocity stamp",
        lambda size: f"each velocity belongs {_steps_words(size, step)} than its row says",
        lambda size: later(size, lambda name: name == CRANK_SPEED or name.rsplit(".", 1)[-1][:1] == "v"),
        0.5 * step,
    )


def _start_hypotheses(question: RunQuestion) -> Iterator[Hypothesis]:
    """Another angle or speed of the crank at time 0."""
    start, scene = question.start, question.scene
    speed = scene.speed if start.speed is None else start.speed
    yield (
        "start speed",
        lambda size: (
            f"the run starts at {_rpm(speed + size)} rpm, not at {_rpm(speed)} rpm: --start {_rpm(speed + size)}rpm"
        ),
        lambda size: question.predict(start=replace(start, speed=speed + size)),
        1e-3 * question.run.speed,
    )
    yield (
        "start angle",
        lambda size: (
            f"the run starts at crank angle {math.degrees(start.angle + size):.6g} deg, not at "
            f"{math.degrees(start.angle):.6g} deg: --start {_rpm(speed)}rpm,{math.degrees(start.angle + size):.6g}deg"
        ),
        lambda size: question.predict(start=CrankStart(start.angle + size, speed)),
        1e-3,
    )


def _mass_hypotheses(question: RunQuestion) -> Iterator[Hypothesis]:
    """Another mass and moment of inertia of a body."""
    mechanism = question.scene.kinematics.mechanism
    if len(mechanism.bodies) > MAX_FIT_BODIES:
        return
    for body in mechanism.bodies:
        yield (
            f"inertia of {body.name}",
            partial(_mass_words, body.name),
            partial(_predict_heavier, question, body.name),
            0.01,
        )


def _mass_words(name: str, size: float) -> str:
    return f"mass and moment of inertia of {name} are {1.0 + size:.6g} times the machine's"


def _predict_heavier(question: RunQuestion, name: str, size: float) -> Values:
    """Predict the run with another mass and moment of inertia of a body, (1 + size) times the machine's."""
    if size <= -1.0:
        raise InvalidInput("no mass is left")
    mechanism, by = question.scene.kinematics.mechanism, 1.0 + size
    bodies = tuple(
        replace(body, mass=by * body.mass, inertia=by * body.inertia) if body.name == name else body
        for body in mechanism.bodies
    )
    return question.predict(mechanism=replace(mechanism, bodies=bodies))


def _load_hypotheses(question: RunQuestion) -> Iterator[Hypothesis]:
    """Gravity or a load that is missing, gravity that is none of the machine, and friction on the crank."""
    mechanism = question.scene.kinematics.mechanism
    others = {(0.0, 0.0): "gravity is missing", (0.0, -GRAVITY): "gravity acts along -y",
              (0.0, GRAVITY): "gravity acts along +y", (-GRAVITY, 0.0): "gravity acts along -x",
              (GRAVITY, 0.0): "gravity acts along +x"}  # fmt: skip
    for gravity, words in others.items():
        if math.dist(gravity, mechanism.gravity) > 0.01 * GRAVITY:
            changed = replace(mechanism, gravity=gravity)
            yield _without_size("gravity", words, partial(question.predict, mechanism=changed))
    for load in mechanism.loads:
        changed = replace(mechanism, loads=tuple(other for other in mechanism.loads if other is not load))
        words = f"{load.name} does not act"
        yield _without_size(f"load {load.name}", words, partial(question.predict, mechanism=changed))
    along = question.torque.acts_on(mechanism).along
    turn, speed = max(_peak(question.torque), 1e-3), question.run.speed
    yield (
        "viscous friction",
        lambda size: f"the crank is damped by {size:.4g} N m s/rad",
        lambda size: question.predict(extra=(Load("damping", along, Viscous(_positive_coefficient(size))),)),
        0.01 * turn / speed,
    )
    if not isinstance(question.torque.law, Sampled) and not question.run.exact[CRANK_SPEED].min() < 0.0:
        return  # the same as a smaller torque
    yield (
        "dry friction",
        lambda size: f"the crank has a dry friction of {size:.4g} N m",
        lambda size: question.predict(
            extra=(Load("friction", along, Friction(_positive_coefficient(size), CREEP_SHARE * speed)),)
        ),
        0.01 * turn,
    )


def _positive_coefficient(size: float) -> float:
    """Size of a friction; raises InvalidInput for one that gives energy."""
    if size < 0.0:
        raise InvalidInput("friction that drives")
    return size


def _peak(torque: Torque) -> float:
    """Largest size of a torque [N m]."""
    law = torque.law
    if isinstance(law, Sampled):
        return max(map(abs, law.sizes))
    return abs(float(law.force(np.zeros(1), np.zeros(1), np.zeros(1))[0]))


def _steps_words(by: float, step: float) -> str:
    """Describe a time shift in seconds and rows, as '0.001 s (0.5 of a row) later'."""
    return f"{abs(by):.4g} s ({abs(by) / step:.3g} of a row) {'later' if by > 0 else 'earlier'}"


def _rpm(speed: float) -> str:
    return f"{speed / RPM:.6g}"
