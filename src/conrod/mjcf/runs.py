"""States and runs of compiled models, what ends a run, and a stepper that begins again where a run ends."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from conrod.comparison.other_forces import OtherForce
from conrod.engines.mujoco.dynamics import bad_number_warnings, silence_warnings
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mjcf.equalities import constraint_violations
from conrod.mjcf.force_watch import ForceWatch

STATE_PARTS = mujoco.mjtState
# All that the next step depends on, and what acts from outside; models that differ by sensors or closures share it.
STATE = int(
    STATE_PARTS.mjSTATE_QPOS
    | STATE_PARTS.mjSTATE_QVEL
    | STATE_PARTS.mjSTATE_ACT
    | STATE_PARTS.mjSTATE_WARMSTART
    | STATE_PARTS.mjSTATE_CTRL
    | STATE_PARTS.mjSTATE_MOCAP_POS
    | STATE_PARTS.mjSTATE_MOCAP_QUAT
)
MAX_SAMPLES = 400


@contextmanager
def user_model_errors(path: Path) -> Iterator[None]:
    """Turn errors of MuJoCo with a user's model into InvalidInput with the file's name; silence its log."""
    with silence_warnings():
        try:
            yield
        except mujoco.FatalError as error:
            raise InvalidInput(f"{path}: MuJoCo gives up on it: {' '.join(str(error).split())}") from None
        except InvalidInput as error:
            raise InvalidInput(f"{path}: {error}") from None


def state_of(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """The state vector (n,) of data, coordinates and rates first."""
    state = np.empty(mujoco.mj_stateSize(model, STATE))
    mujoco.mj_getState(model, data, state, STATE)
    return state


def data_at_state(model: mujoco.MjModel, state: Array) -> mujoco.MjData:
    """Create data in a state (n,)."""
    data = mujoco.MjData(model)
    mujoco.mj_setState(model, data, state, STATE)
    return data


def break_reason(data: mujoco.MjData) -> str:
    """Why a run has broken off: MuJoCo's warning, or "not finite"; empty if it has not."""
    return next(iter(bad_number_warnings(data)), "" if np.all(np.isfinite(data.qpos)) else "not finite")


def looping_stepper(model: mujoco.MjModel, start: Array, max_steps: int) -> Callable[[], Callable[[int], None]]:
    """A factory of functions that advance a run by a number of steps, and restart it at its end.

    Args:
        start: state that the run starts from.
        max_steps: number of steps after which the run starts again: the model is not meant for longer runs.
    """

    def make() -> Callable[[int], None]:
        data, done = data_at_state(model, start), 0

        def advance(steps: int) -> None:
            nonlocal done
            with silence_warnings():
                while steps:
                    if done == max_steps:
                        mujoco.mj_resetData(model, data)
                        mujoco.mj_setState(model, data, start, STATE)
                        done = 0
                    some = min(steps, max_steps - done)
                    mujoco.mj_step(model, data, some)
                    done, steps = done + some, steps - some

        return advance

    return make


@dataclass(frozen=True, eq=False)
class Run:
    """A run with its states, observed points and contacts."""

    model: mujoco.MjModel
    states: Array  # (T, n) at T evenly spaced samples, the first is the start
    points: Array  # (T, p, 3) [m]: origins and centres of gravity of all bodies that can move
    steps: int  # number of steps made until the run ended or broke off
    touched: dict[tuple[int, int], int]  # how many steps a pair of geoms was in contact
    broke: str  # why the run broke off: a warning of MuJoCo, or "not finite"; empty if it came to its end
    acting: tuple[OtherForce, ...] = ()  # besides weight, inertia and the loops

    @property
    def travel(self) -> float:
        """Largest distance [m] of a point from its position at the start."""
        return float(np.linalg.norm(self.points - self.points[0], axis=2).max()) if self.points.size else 0.0

    @property
    def centres(self) -> Array:
        """Centres of gravity (T, p / 2, 3) [m]."""
        return self.points[:, self.points.shape[1] // 2 :]

    def constraint_violations(self, extent: float) -> Array:
        """Violation of each equality (T, neq) [m] at the samples; angles are multiplied by an extent [m]."""
        found = [constraint_violations(self.model, data, extent) for data in forward_at_states(self.model, self.states)]
        return np.reshape(found, (len(found), self.model.neq))


def run(model: mujoco.MjModel, start: Array, steps: int, every: int | None = None, *, watched: bool = True) -> Run:
    """Run a model for a number of steps; ends early if MuJoCo warns of bad numbers.

    Args:
        every: steps from one sample to the next; None for some `MAX_SAMPLES` in all.
        watched: whether contacts and acting forces are recorded, at each step.
    """
    data = data_at_state(model, start)
    every = every or max(1, -(-steps // MAX_SAMPLES))
    states, touched, done, watch = list[Array](), dict[tuple[int, int], int](), 0, ForceWatch(model)
    with silence_warnings():
        while not break_reason(data):
            states.append(state_of(model, data))
            some = min(every, steps - done)
            if watched:
                _step_watched(model, data, some, watch, touched)
            elif some:
                mujoco.mj_step(model, data, some)
            done += some
            if watched and some == every:
                watch.sample(data)
            if some < every:
                break
        moving = model.body_weldid > 0
        points = np.array(
            [np.vstack([seen.xpos[moving], seen.xipos[moving]]) for seen in forward_at_states(model, states)]
        )
    broke = break_reason(data) or ("" if np.isfinite(points).all() else "not finite")
    return Run(model, np.reshape(states, (len(states), len(start))), points, done, touched, broke, watch.found)


def _step_watched(
    model: mujoco.MjModel, data: mujoco.MjData, steps: int, watch: ForceWatch, touched: dict[tuple[int, int], int]
) -> None:
    """Take steps, and record the constraint forces of each and the pairs of geoms that touch."""
    for _ in range(steps):
        mujoco.mj_step(model, data)
        watch.step(data)
        if data.ncon:
            # A contact within its margin that makes no force has no row.
            acting = data.contact.geom[data.contact.efc_address >= 0].tolist()
            for pair in {(min(geoms), max(geoms)) for geoms in acting}:
                touched[pair] = touched.get(pair, 0) + 1


def forward_at_states(model: mujoco.MjModel, states: Iterable[Array]) -> Iterator[mujoco.MjData]:
    """Yield data with positions and constraints at each state; the same object every time.

    After a step, positions in the data of a run belong to the instant before it.
    """
    data = mujoco.MjData(model)
    for state in states:
        mujoco.mj_setState(model, data, state, STATE)
        mujoco.mj_fwdPosition(model, data)
        yield data
