"""The study of a model's invariances: its run, the changes, and the comparison at states of the run."""

from __future__ import annotations

import hashlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mjcf.invariances.changes import Bench, reversed_declaration, similarities, solving_changed
from conrod.mjcf.invariances.results import Invariance, Kept
from conrod.mjcf.lint.document import Document
from conrod.mjcf.runs import SAMPLES, run, state_of
from conrod.own.models.loading import check_finite, data_at_start, load_model, start_words
from conrod.own.models.request import Controls

STEPS = 1000  # of the run, unless it is said how long it is
COMPARED = 12  # states of it
THREADS = 4


def bits(path: Path, seconds: float | None, keyframe: str | None, controls: Controls) -> str:
    """Digest of all states of a model's run; to be called in a process of its own."""
    return _digest(load_model(path), *_start(load_model(path), seconds, keyframe, controls))


def study(
    path: Path, seconds: float | None, keyframe: str | None, controls: Controls, elsewhere: str
) -> tuple[str, tuple[Invariance, ...]]:
    """The run of a model file in words, and its invariances; to be called in a process of its own.

    Args:
        elsewhere: `bits` of another process.

    Raises:
        InvalidInput: the file cannot be loaded, or its run breaks off at once.
    """
    model = load_model(path)
    check_finite(model)
    if not model.nv:
        raise InvalidInput(f"{path}: nothing in it moves: it has no joint")
    start, steps = _start(model, seconds, keyframe, controls)
    document = None if path.suffix.lower() == ".mjb" else Document(path)
    with warnings_kept_quiet():
        bench = _bench(model, start, steps, document)
        own = _digest(model, start, steps)
        with ThreadPoolExecutor(THREADS) as threads:
            together = set(threads.map(lambda _: _digest(model, start, steps), range(THREADS)))
        same = {"run again": {own, _digest(model, start, steps)}, "another process": {own, elsewhere}}
        found = [
            _same_bits(change, digests) for change, digests in (same | {f"{THREADS} threads": together | {own}}).items()
        ]
        found += [*solving_changed(bench), *similarities(bench), reversed_declaration(bench)]
    broke = "; the run breaks off, and states before that are compared" if bench.broke else ""
    words = f"{steps} steps of {model.opt.timestep:g} s; accelerations at {len(bench.times)} states of them"
    return f"{words}, from {start_words(model, data_at_start(model, keyframe, controls)[1])}{broke}", tuple(found)


def _start(model: mujoco.MjModel, seconds: float | None, keyframe: str | None, controls: Controls) -> tuple[Array, int]:
    steps = STEPS if seconds is None else max(1, round(seconds / model.opt.timestep))
    return state_of(model, data_at_start(model, keyframe, controls)[0]), steps


def _digest(model: mujoco.MjModel, start: Array, steps: int) -> str:
    return hashlib.sha256(run(model, start, steps).states.tobytes()).hexdigest()


def _same_bits(change: str, digests: set[str]) -> Invariance:
    return Invariance(change, "bits", Kept.BITS if len(digests) == 1 else Kept.BROKEN)


def _bench(model: mujoco.MjModel, start: Array, steps: int, document: Document | None) -> Bench:
    """A model with some states of its run.

    Raises:
        InvalidInput: its run breaks off before there is a state.
    """
    made = run(model, start, steps)
    every = max(1, len(made.states) // COMPARED)
    states = made.states[::every][:COMPARED]
    if not len(states):
        raise InvalidInput("its run breaks off at the start")
    interval = model.opt.timestep * max(1, -(-steps // SAMPLES)) * every
    return Bench.of(model, interval * np.arange(len(states)), states, document, made.broke)
