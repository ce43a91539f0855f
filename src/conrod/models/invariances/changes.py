"""Changes of a model that must not matter, each with the difference that it makes to the accelerations of its run."""

from __future__ import annotations

import contextlib
import copy
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from conrod.engines.mujoco import compat
from conrod.exact.motion import Array
from conrod.exact.space import COORDINATES, RATES
from conrod.mjcf.loading import joint_kind
from conrod.mjcf.runs import data_at_state
from conrod.models.invariances.accelerations import (
    Accelerations,
    Similarity,
    accelerations,
    forward,
    with_converged_solver,
)
from conrod.models.invariances.results import Invariance, InvarianceOutcome

TURN_AXIS = np.array([1.0, 2.0, 3.0]) / math.sqrt(14.0)
TURN_QUATERNION = (math.cos(0.5), *(math.sin(0.5) * TURN_AXIS).tolist())  # by one radian about no axis of the world
SIMILARITIES = {
    "masses doubled": Similarity(mass=2.0),
    "world turned": Similarity(turn=TURN_QUATERNION),
}


@dataclass(frozen=True, eq=False)
class InvarianceBench:
    """A model with its accelerations at states of its run.

    Attributes:
        times, states: times (T,) [s] and states (T, n) of the run, as `conrod.mjcf.runs` records them.
        reference: accelerations at each state, solved on dense matrices to convergence, with their rounding bound.
        broke: whether the run broke off, by a warning of MuJoCo or a number that is not finite.
    """

    model: mujoco.MjModel
    times: Array
    states: Array
    reference: tuple[Accelerations, ...]
    broke: bool = False

    @classmethod
    def from_states(cls, model: mujoco.MjModel, times: Array, states: Array, broke: bool = False) -> InvarianceBench:
        """Solve the reference accelerations of a model at states (T, n) of its run."""
        solved = with_converged_solver(model)
        return cls(model, times, states, tuple(accelerations(solved, state) for state in states), broke)

    @property
    def size(self) -> float:
        """Largest norm of the accelerations at a state."""
        return max(one.size for one in self.reference)

    def judge_change(self, change: str, others: Callable[[Array], Array]) -> Invariance:
        """Judge a change by the accelerations (nv,) that it gives at each state."""
        return self.judge_accelerations(change, "rounding", [others(state) for state in self.states])

    def judge_accelerations(
        self, change: str, bound: str, others: Sequence[Array], residuals: Sequence[float] | None = None
    ) -> Invariance:
        """Judge a change by its accelerations (nv,) at each state, within rounding and residuals of solvers.

        Args:
            bound: name of the bound.
            residuals: at each state, how far the solvers may be from the minimum, in the norm of the kinetic energy.
        """
        offs = [one.difference(values) for one, values in zip(self.reference, others, strict=True)]
        bounds = [one.bound + more for one, more in zip(self.reference, residuals or [0.0] * len(offs), strict=True)]
        ratios = [_ratio(off, allowed) for off, allowed in zip(offs, bounds, strict=True)]
        out = [k for k, ratio in enumerate(ratios) if not ratio <= 1.0]
        worst = out[0] if out else int(np.argmax(ratios))
        outcome = InvarianceOutcome.BROKEN if out else InvarianceOutcome.HOLDS
        return Invariance(change, bound, outcome, _ratio(max(offs), self.size), max(ratios), float(self.times[worst]))


def _ratio(value: float, bound: float) -> float:
    return 0.0 if value == 0.0 else value / bound if bound > 0.0 else math.inf


# -- settings of the solver --------------------------------------------------------------------------------------------


def _switch_islands(model: mujoco.MjModel) -> None:
    if bit := compat.disable_bit("ISLAND"):
        model.opt.disableflags ^= bit
    else:  # which had to be asked for, until 3.3.5
        model.opt.enableflags ^= int(mujoco.mjtEnableBit.mjENBL_ISLAND)


SETTINGS: dict[str, Callable[[mujoco.MjModel], None]] = {
    "sparse Jacobian": lambda model: setattr(model.opt, "jacobian", mujoco.mjtJacobian.mjJAC_SPARSE),
    "islands switched": _switch_islands,
}


def solver_settings(bench: InvarianceBench) -> Iterator[Invariance]:
    """Check a sparse Jacobian and constraint islands, one at a time."""
    for change, edit in SETTINGS.items():
        edited = with_converged_solver(bench.model)
        edit(edited)
        yield bench.judge_change(change, partial(_solve_accelerations, edited))


def _solve_accelerations(model: mujoco.MjModel, state: Array) -> Array:
    return np.array(forward(model, state).qacc)


def warm_start(bench: InvarianceBench) -> Invariance:
    """Check the solver's warm start."""
    solved = with_converged_solver(bench.model)

    def accelerations_from_guess(state: Array) -> Array:
        data = data_at_state(solved, state)
        mujoco.mj_forward(solved, data)
        return np.array(data.qacc)

    return bench.judge_change("warm start", accelerations_from_guess)


# -- the machine in other words ----------------------------------------------------------------------------------------


def similarities(bench: InvarianceBench) -> Iterator[Invariance]:
    """Check another unit of mass, and a rotated world."""
    for change, similarity in SIMILARITIES.items():
        if reason := similarity.refusal(bench.model):
            yield Invariance(change, "rounding", InvarianceOutcome.UNSUPPORTED, reason=reason)
        else:
            own = _with_elliptic_cone(bench) if similarity.turned else bench
            yield own.judge_change(change, _image_accelerations(own.model, similarity))


def _with_elliptic_cone(bench: InvarianceBench) -> InvarianceBench:
    """Replace a pyramidal friction cone, whose edges follow the world's axes, by the elliptic one."""
    if bench.model.opt.cone != mujoco.mjtCone.mjCONE_PYRAMIDAL:
        return bench
    model = copy.copy(bench.model)
    model.opt.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    return InvarianceBench.from_states(model, bench.times, bench.states)


def _image_accelerations(model: mujoco.MjModel, similarity: Similarity) -> Callable[[Array], Array]:
    """Return a function of a state: the image's accelerations, in the model's coordinates."""
    solved = with_converged_solver(model)
    image, rates = similarity.apply(solved), similarity.rate_matrix(solved)

    def image_accelerations(state: Array) -> Array:
        own, data = data_at_state(solved, state), mujoco.MjData(image)
        data.qpos[:], data.qvel[:] = similarity.positions(solved, own.qpos), rates @ own.qvel
        data.ctrl[:] = own.ctrl
        mujoco.mj_forward(image, data)
        return np.asarray(np.linalg.solve(rates, data.qacc))

    return image_accelerations


def reversed_declaration(bench: InvarianceBench, path: Path) -> Invariance:
    """Check the elements of every body, and the equality constraints, declared in reverse order."""
    change = "order of declaration"
    try:
        named, reverse = both_orders(path)
    except (ValueError, mujoco.FatalError) as error:
        return Invariance(change, "rounding", InvarianceOutcome.UNSUPPORTED, reason=" ".join(str(error).split()))
    positions, rates = joint_addresses(named, reverse)
    solved, written = with_converged_solver(reverse), InvarianceBench.from_states(named, bench.times, bench.states)

    def reordered_accelerations(state: Array) -> Array:
        own, data = data_at_state(named, state), mujoco.MjData(solved)
        data.qpos[positions], data.qvel[rates] = own.qpos, own.qvel
        data.ctrl[:], data.act[:] = own.ctrl, own.act
        mujoco.mj_forward(solved, data)
        return np.asarray(data.qacc[rates])

    return written.judge_change(change, reordered_accelerations)


def joint_addresses(one: mujoco.MjModel, other: mujoco.MjModel) -> tuple[list[int], list[int]]:
    """Indices of one model's coordinates (nq,) and rates (nv,) in another with the same names of joints."""
    positions, rates = list[int](), list[int]()
    for joint in range(one.njnt):
        there, kind = other.joint(one.joint(joint).name).id, joint_kind(one, joint)
        positions += range(other.jnt_qposadr[there], other.jnt_qposadr[there] + COORDINATES[kind])
        rates += range(other.jnt_dofadr[there], other.jnt_dofadr[there] + RATES[kind])
    return positions, rates


JOINTS = ("joint", "freejoint")


def both_orders(path: Path) -> tuple[mujoco.MjModel, mujoco.MjModel]:
    """Compile a model as MuJoCo writes it, and with elements of bodies and constraints in reverse order.

    Joints have names in both.

    Raises:
        ValueError: there is no file to take apart, or what MuJoCo writes does not compile.
    """
    if path.suffix.lower() == ".mjb":
        raise ValueError("there is no file to take apart")
    spec = mujoco.MjSpec.from_file(str(path))
    with contextlib.chdir(path.resolve().parent):
        spec.compile()
        root = ElementTree.fromstring(spec.to_xml())
        for number, joint in enumerate(e for body in root.iterfind("worldbody") for e in body.iter()):
            if joint.tag in JOINTS:
                joint.attrib.setdefault("name", f"conrod-{number}")
        named = mujoco.MjModel.from_xml_string(ElementTree.tostring(root))
        for section in root.iter():
            if section.tag in ("equality", "worldbody", "body"):
                # A body's own joints are one after the other: their order is part of the machine.
                moving = [child for child in section if child.tag not in JOINTS]
                section[:] = [child for child in section if child not in moving] + moving[::-1]
        return named, mujoco.MjModel.from_xml_string(ElementTree.tostring(root))
