"""Kinematic mode of a user's own model: one turn of its crank, held at angle after angle."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mobility import jacobian_rank
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.models.assembly import Assembly, prepare
from conrod.own.models.facts import own_settings, remarks, stops, touching, wiring
from conrod.own.models.loading import controls_at_start, keyframe_to_start_from, start_words
from conrod.own.models.request import ModelFacts, Question, Scan

SAMPLES = 180  # in a turn
# A point that is not back after a turn is away by more than this share of the model.
RETURNED = 1e-6


def scan(path: Path, question: Question) -> Scan:
    """One turn of a model; to be called in a process of its own, see `conrod.studies.execution.isolation`.

    Raises:
        InvalidInput: see `prepare`; or the model cannot turn fully.
    """
    try:
        return _scanned(prepare(path, question), question)
    except InvalidInput as error:
        raise error if str(error).startswith(str(path)) else InvalidInput(f"{path}: {error}") from None


def _scanned(assembly: Assembly, question: Question) -> Scan:
    """Samples at `SAMPLES` angles, and one a turn later, which shows whether all is back."""
    model, crank, start = assembly.original, assembly.crank, assembly.coordinate()
    controls = controls_at_start(model, question.keyframe, question.controls)
    ranks, samples, gaps = [jacobian_rank(assembly.jacobian())], [], []
    for turn in np.linspace(0.0, 2.0 * np.pi, SAMPLES + 1):
        assembly.go(start + float(turn))
        samples.append(_sample(assembly))
        gaps.append(assembly.gap())
        ranks.append(jacobian_rank(assembly.jacobian()))
    states, rates, positions, slopes, links, spins, anchors, axes = (
        np.array(column) for column in zip(*samples, strict=True)
    )
    off = float(np.linalg.norm(positions[-1] - positions[0], axis=-1).max())
    if off > RETURNED * float(model.stat.extent):
        raise InvalidInput(f"after one turn of its crank a point is {off:.3g} away from where it was")
    wired, pair, again, whole = wiring(assembly, ranks), assembly.touching, states[-1], slice(0, -1)
    gap, open_closure = max(gaps[whole], key=lambda gap: gap[0])
    facts = ModelFacts(
        name=model.names[: model.names.index(b"\0")].decode(errors="replace"),
        engine_version=mujoco.__version__,
        wiring=wired,
        touching=None if pair is None else touching(model, pair, axes[0]),
        settings=own_settings(model),
        gap=gap,
        open_closure=open_closure,
        stops=stops(model, crank, states[whole]),
        remarks=remarks(model, crank),
        start=start_words(model, keyframe_to_start_from(model, question.keyframe), controls.values()),
        controls=controls,
    )
    away = np.linalg.norm([anchors[whole] - anchors[0], axes[whole] - axes[0]], axis=-1)
    return Scan(
        facts=facts,
        coordinate=states[whole, crank.coordinate],
        points=tuple(point.name for point in assembly.points),
        positions=positions[whole].swapaxes(0, 1),
        slopes=None if pair else slopes[whole].swapaxes(0, 1),
        turns=_turns(links[whole], axes[whole]).T,
        spins=(spins[whole] @ axes[whole, :, None])[..., 0].T,
        states=states[whole],
        rates=_differences(model, states[whole], again) if pair else rates[whole],
        anchor=anchors[0],
        axis=axes[0],
        wander=float(away.max()),
    )


def _sample(assembly: Assembly) -> tuple[Array, ...]:
    """State, rates, the points' positions, slopes, links (P, 3, 3) and their spins, the crank's anchor and axis."""
    model, data, crank, points, rates = assembly.model, assembly.data, assembly.crank, assembly.points, assembly.rates()
    mujoco.mj_comPos(model, data)
    jacobians = [point.jacobians(model, data) for point in points]
    return (
        data.qpos.copy(),
        rates,
        np.array([point.position(data) for point in points]),
        np.array([along @ rates for along, _ in jacobians]),
        np.array([data.xmat[point.body].reshape(3, 3) for point in points]),
        np.array([about @ rates for _, about in jacobians]),
        data.xanchor[crank.joint].copy(),
        data.xaxis[crank.joint].copy(),
    )


def _turns(links: Array, axes: Array) -> Array:
    """Angles (T, P) [rad] about an axis (T, 3) by which links (T, P, 3, 3) have turned since the first of them."""
    turned = links @ links[0].swapaxes(-1, -2)
    back = turned.swapaxes(-1, -2)
    across = 0.5 * (turned - back)[..., [2, 0, 1], [1, 2, 0]]
    return np.asarray(np.arctan2((across @ axes[:, :, None])[..., 0], 0.5 * (turned.trace(axis1=-2, axis2=-1) - 1.0)))


def _differences(model: mujoco.MjModel, states: Array, again: Array) -> Array:
    """Rates (T, nv) by central differences of a closed turn's states (T, nq); `again` is the first a turn later."""
    count = len(states)
    # The last sample before the first one lies a turn further.
    around = np.vstack([states[-1] - (again - states[0]), states, again])
    rates = np.empty((count, model.nv))
    for k in range(count):
        mujoco.mj_differentiatePos(model, rates[k], 4.0 * np.pi / count, around[k], around[k + 2])
    return rates
