"""Kinematic mode of a user's own model: one turn of its crank, held at angle after angle."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.mobility import mobility
from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array
from conrod.own.models.assembly import Assembly
from conrod.own.models.loading import check_finite, load_model, names_of_keyframes
from conrod.own.models.model_facts import ModelFacts
from conrod.own.models.own_settings import own_settings, remarks, stops
from conrod.own.models.points import Crank, FoundPoint, find_crank, find_point
from conrod.own.models.request import Question, Scan
from conrod.own.models.touching import Gap, find_gap, touching
from conrod.own.models.wiring import check_freedom, wiring

SAMPLES = 180  # in a turn
# A point that is not back after a turn, or a crank's axis that moves, by more than this share of the model.
RETURNED = 1e-6


@dataclass(frozen=True)
class Prepared:
    """A model with what was asked for found in it, assembled at its start pose."""

    model: mujoco.MjModel
    crank: Crank
    points: tuple[FoundPoint, ...]
    assembly: Assembly
    gap: Gap | None


@dataclass(frozen=True)
class _Sample:
    """The model at one angle; slopes are by the crank's coordinate."""

    coordinate: float
    state: Array
    rates: Array
    positions: list[Array]
    slopes: list[Array]
    links: list[Array]  # orientations of the points' links (3, 3)
    spins: list[Array]  # derivatives of their turns (3,)
    anchor: Array
    axis: Array
    gap: tuple[float, str]


def scan(path: Path, question: Question) -> Scan:
    """One turn of a model; to be called in a process of its own, see `conrod.studies.execution.isolation`.

    Raises:
        InvalidInput: the model cannot be loaded, has not what was asked for, is of another mobility than the machine,
            cannot be assembled, or cannot turn fully.
    """
    try:
        return _scanned(prepare(path, question), question)
    except InvalidInput as error:
        raise error if str(error).startswith(str(path)) else InvalidInput(f"{path}: {error}") from None


def prepare(path: Path, question: Question) -> Prepared:
    """Load a model, find what was asked for and assemble it at its start pose.

    Raises:
        InvalidInput: see `scan`.
    """
    model = load_model(path)
    check_finite(model)
    crank = find_crank(model, question.crank)
    points = tuple(find_point(model, place) for place in question.places)
    assembly = Assembly(model, crank)
    _assemble(assembly, question)
    check_freedom(assembly, question)
    gap = None
    if question.touching is not None and not len(assembly.left_free()):
        raise InvalidInput("--touching: its closures place everything, and leave nothing to a contact")
    if len(assembly.left_free()) and question.contacts:
        gap = find_gap(assembly, question.touching)
        gap.close()
        assembly.place_rest = gap.close
    return Prepared(model, crank, points, assembly, gap)


def _assemble(assembly: Assembly, question: Question) -> None:
    """Close the loops from the pose that is asked for, or from the first of the model's own that can be closed."""
    model, keys = assembly.model, names_of_keyframes(assembly.model)
    if question.keyframe is not None:
        if question.keyframe not in keys:
            if not any(keys):
                raise InvalidInput(f"--keyframe {question.keyframe}: the model has no keyframe with a name")
            raise unknown_choice("keyframe", question.keyframe, [key for key in keys if key])
        poses = [model.key_qpos[keys.index(question.keyframe)]]
    else:
        poses = [model.qpos0, *model.key_qpos]
    for k, pose in enumerate(poses):
        assembly.data.qpos[:] = pose
        try:
            assembly.close()
            return
        except InvalidInput:
            if k == len(poses) - 1:
                raise


def _scanned(prepared: Prepared, question: Question) -> Scan:
    assembly, model = prepared.assembly, prepared.model
    start = assembly.coordinate()
    ranks, samples = [mobility(assembly.model, assembly.data).rank], list[_Sample]()
    for turn in np.linspace(0.0, 2.0 * np.pi, SAMPLES + 1):
        assembly.go(start + float(turn))
        samples.append(_sample(prepared))
        ranks.append(mobility(assembly.model, assembly.data).rank)
    _check_return(samples, float(model.stat.extent))
    wired = wiring(assembly, ranks)
    *samples, last = samples
    first, by_contact = samples[0], prepared.gap is not None
    states = np.array([s.state for s in samples])
    named = [(k, place.point) for k, place in enumerate(question.places)]
    gap, open_closure = max((s.gap for s in samples), key=lambda gap: gap[0])
    facts = ModelFacts(
        name=model.names[: model.names.index(b"\0")].decode(errors="replace"),
        engine_version=mujoco.__version__,
        wiring=wired,
        touching=None if prepared.gap is None else touching(prepared.gap, model, first.axis),
        settings=own_settings(model),
        gap=gap,
        open_closure=open_closure,
        stops=stops(model, prepared.crank, states),
        remarks=remarks(model, prepared.crank),
    )
    return Scan(
        facts=facts,
        coordinate=np.array([s.coordinate for s in samples]),
        positions={n: np.array([s.positions[k] for s in samples]) for k, n in named},
        slopes=None if by_contact else {n: np.array([s.slopes[k] for s in samples]) for k, n in named},
        turns={n: np.array([_turn(s.links[k], first.links[k], s.axis) for s in samples]) for k, n in named},
        spins={n: np.array([s.spins[k] @ s.axis for s in samples]) for k, n in named},
        states=states,
        rates=_differences(model, states, last.state) if by_contact else np.array([s.rates for s in samples]),
        anchor=first.anchor,
        axis=first.axis,
        wander=max(_apart(s, first) for s in samples),
    )


def _sample(prepared: Prepared) -> _Sample:
    assembly, crank = prepared.assembly, prepared.crank
    data, rates = assembly.data, assembly.rates()
    mujoco.mj_comPos(assembly.model, data)
    jacobians = [point.jacobians(assembly.model, data) for point in prepared.points]
    return _Sample(
        coordinate=assembly.coordinate(),
        state=data.qpos.copy(),
        rates=rates,
        positions=[point.position(data) for point in prepared.points],
        slopes=[along @ rates for along, _ in jacobians],
        links=[data.xmat[point.body].reshape(3, 3).copy() for point in prepared.points],
        spins=[about @ rates for _, about in jacobians],
        anchor=data.xanchor[crank.joint].copy(),
        axis=data.xaxis[crank.joint].copy(),
        gap=assembly.gap(),
    )


def _turn(link: Array, before: Array, axis: Array) -> float:
    """Angle [rad] about an axis by which a link turned from one orientation (3, 3) to another."""
    turned = link @ before.T
    across = 0.5 * np.array([turned[2, 1] - turned[1, 2], turned[0, 2] - turned[2, 0], turned[1, 0] - turned[0, 1]])
    return float(np.arctan2(across @ axis, 0.5 * (np.trace(turned) - 1.0)))


def _apart(one: _Sample, other: _Sample) -> float:
    """Distance of two anchors or axes, the larger of both."""
    return max(float(np.linalg.norm(one.anchor - other.anchor)), float(np.linalg.norm(one.axis - other.axis)))


def _check_return(samples: list[_Sample], extent: float) -> None:
    first, last = samples[0], samples[-1]
    off = max(float(np.linalg.norm(b - a)) for a, b in zip(first.positions, last.positions, strict=True))
    if off > RETURNED * extent:
        raise InvalidInput(f"after one turn of its crank a point is {off:.3g} away from where it was")


def _differences(model: mujoco.MjModel, states: Array, again: Array) -> Array:
    """Rates (T, nv) by central differences of a closed turn's states (T, nq); `again` is the first a turn later."""
    count = len(states)
    # The last sample before the first one lies a turn further.
    around = np.vstack([states[-1] - (again - states[0]), states, again])
    rates = np.empty((count, model.nv))
    for k in range(count):
        mujoco.mj_differentiatePos(model, rates[k], 4.0 * np.pi / count, around[k], around[k + 2])
    return rates
