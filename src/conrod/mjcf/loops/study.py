"""The study of a model's closed loops: its exact motion, MuJoCo's kinematics, its runs and the cheapest settings."""

from __future__ import annotations

import copy
import math
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.engines.mujoco.settings import HARDENING, MuJoCoSettings
from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array
from conrod.exact.space.forces import SpatialForces, forces
from conrod.exact.space.laws import FORMS, Law, law_of
from conrod.exact.space.mobility import Mobility, check_drives, mobility
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.exact.space.tree import SpatialTree
from conrod.mjcf.loops.differences import Comparison, changes, compared
from conrod.mjcf.loops.driving import Recording, driven_run, free_run, gaps_of, shipped_run, site_points, start_state
from conrod.mjcf.loops.reading import check_rigid, tree_of
from conrod.mjcf.loops.results import OWN, QUANTITIES, FreeRun, LoopRun, LoopStudy, Question, ShippedRun
from conrod.mjcf.runs import looping_stepper, state_of
from conrod.own.error_curve import error_curve
from conrod.own.models.driving import ordered
from conrod.own.models.loading import (
    FoundPoint,
    check_finite,
    data_at_start,
    element_id,
    listed,
    load_model,
    name_or_number,
    names_of,
    numbered,
    start_words,
)
from conrod.own.models.request import Order
from conrod.runs.convergence import claimed_order
from conrod.runs.outcome import OPEN_GAP
from conrod.runs.trajectory import Outcome
from conrod.scenes.space import MACHINES

LABELS = (OWN, "tuned", "hardened")
# Steps of the model's own that runs are refined and coarsened to, and samples that a run keeps.
FINER, COARSER, SAMPLES = (1, 2, 4), (2, 4), 2000
CHECKED, MOST_STEPS = 180, 10**6
TIMED = 0.15  # [s]
# Hardening of a machine with an idle spin: an RSSR linkage whose rod has 1/500 of its inertia about itself is off by
# 1 mm at 1e-9 and by 1e-7 mm at 1e-7 (1 m, 1 ms).
SOFTER = 1e-7


def study(path: Path, question: Question, name: str) -> LoopStudy:
    """Judge a model file; to be called in a process of its own, see `conrod.studies.execution.isolation`.

    Raises:
        InvalidInput: the model cannot be used, its drives are too few or too many, or its loops cannot be closed.
    """
    model, against = load_model(path), ""
    try:
        check_finite(model)
        check_rigid(model)
        machine = None if question.machine is None else machine_tree(question.machine)
        if machine is not None:
            found = changes(tree_of(model, data_at_start(model, question.keyframe)[0].qpos), machine)
            against = f"; against {question.machine}: {'; '.join(words for words, _ in found)}"
        return _Bench.of(model, question).studied(str(path), name, machine)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {str(error).removeprefix(f'{path}: ')}{against}") from None


def machine_tree(machine: str) -> SpatialTree:
    """The machine of a name, or of a model file."""
    if machine in MACHINES:
        model = mujoco.MjModel.from_xml_string(MACHINES[machine]().mjcf)
    else:
        model = load_model(Path(machine))
    return tree_of(model, data_at_start(model, None)[0].qpos)


@dataclass(frozen=True, eq=False)
class _Bench:
    """A model with its exact machine, from its start on."""

    model: mujoco.MjModel
    question: Question
    machine: DrivenTree
    data: mujoco.MjData
    misfit: float
    seconds: float
    freedom: Mobility
    points: tuple[FoundPoint, ...]

    @classmethod
    def of(cls, model: mujoco.MjModel, question: Question) -> _Bench:
        data, _ = data_at_start(model, question.keyframe)
        tree = tree_of(model, data.qpos, data.eq_active)
        if not tree.closures:
            off = [name_or_number(model, "equality", k) for k in range(model.neq)]
            raise InvalidInput(f"it has no closed loop{f'; switched off: {listed(off)}' if off else ''}")
        laws, held = laws_of(model, tree, question)
        machine = DrivenTree(tree, laws, held)
        start, misfit = machine.closed(tree.start[:, None], 0.0)
        check_drives(machine, start)
        seconds = question.seconds or _duration(laws)
        machine.go(start, seconds)
        freedom = mobility(machine)
        return cls(model, question, machine, data, misfit, seconds, freedom, _points(model, tree, freedom, question))

    def studied(self, file: str, name: str, machine: SpatialTree | None) -> LoopStudy:
        """All that is found."""
        checked = self.machine.motion(np.linspace(0.0, self.seconds, CHECKED))
        judged = [checked.points[point.name].position for point in self.points]
        travel = max(float(np.linalg.norm(p - p[0], axis=1).max()) for p in judged)
        if travel <= 1e-9 * self.machine.tree.extent:
            raise InvalidInput(f"no judged point moves with these drives: {', '.join(p.name for p in self.points)}")
        kinematic, remarks = kinematic_mode(self, checked)
        runs, steps = self._runs(travel)
        unknown = self._unknown_forces()
        exact = None if unknown else forces(self.machine, checked)
        allowed = self.question.tolerance
        within = [run for run in (*runs, *steps) if allowed and run.cost is not None and run.within(allowed)]
        return LoopStudy(
            file, name, mujoco.__version__, self.question, self.seconds, travel, self.machine.held, self.freedom,
            self.misfit, kinematic, () if exact is None else exact.ambiguous, unknown, remarks,
            self._shipped(travel), runs, steps, self._free(checked),
            min(within, key=lambda run: run.cost or math.inf, default=None), self._compared(machine, checked, travel),
        )  # fmt: skip

    def _compared(self, machine: SpatialTree | None, motion: SpatialMotion, travel: float) -> Comparison | None:
        """Against the machine that it is to be, and its closed form where it has one."""
        if machine is None or (name := self.question.machine) is None:
            return None
        driven = self.machine
        found = compared(name, driven.tree, machine, driven.laws, driven.held, motion)
        if name not in MACHINES:
            return found
        laws = {joint: law.derivatives(motion.times)[:3] for joint, law in driven.laws.items()}
        exact = MACHINES[name]().points(laws)
        off = (np.abs(exact[p][0] - motion.points[p].position).max() for p in exact if p in motion.points)
        return replace(found, closed_form=max(map(float, off)) / travel)

    def _unknown_forces(self) -> tuple[str, ...]:
        """What acts that the exact motion does not tell, in words."""
        spins = (f"{', '.join(self.freedom.idle)} idle, whose spin no drive determines",) if self.freedom.idle else ()
        return (*self.machine.tree.unmodelled, *spins)

    # -- runs ---------------------------------------------------------------------------------------------------------

    def _runs(self, travel: float) -> tuple[tuple[LoopRun, ...], tuple[LoopRun, ...]]:
        """At the model's own step, each with its order and cost; and at other steps."""
        at_own, others = list[LoopRun](), list[LoopRun]()
        costs = self._costs()
        for label in LABELS:
            made = {n: self._run(label, n, travel) for n in (*(1.0 / c for c in COARSER), *map(float, FINER))}
            by_step = sorted((round(COARSER[-1] * n), run.errors.get("position")) for n, run in made.items())
            order = claimed_order(by_step)
            priced = {n: replace(run, cost=costs[label] * n) for n, run in made.items()}
            at_own.append(replace(priced[1.0], order=order))
            others += [run for n, run in priced.items() if n != 1.0]
        return tuple(at_own), tuple(others)

    def _run(self, label: str, finer: float, travel: float) -> LoopRun:
        """A run with a step so many times finer than the model's own, compared with the exact motion."""
        step = float(self.model.opt.timestep) / finer
        count = max(2, round(self.seconds / step))
        if count > MOST_STEPS:
            return LoopRun(label, step, Outcome.UNSUPPORTED, f"{count} steps: at most {MOST_STEPS} are made")
        every = max(1, count // SAMPLES)
        motion = self.machine.motion(np.asarray(step * np.arange(0, count + 1, every), dtype=float))
        model = self._with(label, step)
        exact = None if self._unknown_forces() else forces(self.machine, motion)
        return judged(
            label, step, driven_run(self.machine, model, motion, self.points, every), motion, self.machine, travel
        )

    def _with(self, label: str, step: float) -> mujoco.MjModel:
        return with_settings(self.model, label, step, self.seconds, bool(self.freedom.idle))

    def _costs(self) -> dict[str, float]:
        """Cost of a step with each preset's settings over that with the model's own, measured in turns."""
        start = self.machine.motion(np.zeros(1))
        steppers, spent = {}, dict.fromkeys(LABELS, math.inf)
        for label in LABELS:
            model = self._with(label, float(self.model.opt.timestep))
            data = mujoco.MjData(model)
            start_state(data, start)
            steppers[label] = looping_stepper(model, state_of(model, data), 100)()
        for _ in range(5):
            for label, advance in steppers.items():
                spent[label] = min(spent[label], _timed(advance))
        return {label: value / spent[OWN] for label, value in spent.items()}

    def _shipped(self, travel: float) -> ShippedRun:
        """The file as it is, with the controls that are asked for."""
        numbers, laws = dict[str, float](), dict[int, Callable[[float], float]]()
        names = numbered(names_of(self.model, "actuator"))
        for actuator, text in self.question.controls.items():
            if actuator not in names:
                raise unknown_choice("actuator", actuator, names)
            try:
                numbers[actuator] = float(text)
            except ValueError:
                laws[names.index(actuator)] = _control_law(text, actuator)
        data, key = data_at_start(self.model, self.question.keyframe, tuple(numbers.items()))
        words = start_words(self.model, key, data.ctrl.tolist())
        return shipped_run(copy.copy(self.model), data, laws, self.seconds, words, travel)

    def _free(self, motion: SpatialMotion) -> tuple[FreeRun, ...]:
        """A floating machine let go; nothing where its base does not float."""
        if not self.machine.held:
            return ()
        step = float(self.model.opt.timestep)
        return tuple(
            free_run(label, with_settings(self.model, label, step, self.seconds, True), motion, self.seconds)
            for label in LABELS
        )


# -- what is asked ---------------------------------------------------------------------------------------------------


def laws_of(model: mujoco.MjModel, tree: SpatialTree, question: Question) -> tuple[dict[str, Law], tuple[str, ...]]:
    """Laws of the driven joints, and the joints that are held: free joints under what closes.

    Raises:
        InvalidInput: a drive is no joint, no hinge or slide, or its law leaves the joint's range.
    """
    by_name, laws = {joint.name: joint for joint in tree.joints}, dict[str, Law]()
    drivable = [one.name for one in tree.joints if one.kind in ("hinge", "slide")]
    for name, text in question.drives.items():
        if name not in by_name:
            if name in numbered(names_of(model, "actuator")):
                moved = name_or_number(
                    model, "joint", int(model.actuator_trnid[element_id(model, "actuator", name), 0])
                )
                raise InvalidInput(f"--drive {name}: it is an actuator; drive its joint: --drive {moved}={text}")
            raise unknown_choice("joint", name, drivable)
        joint = by_name[name]
        if joint.kind not in ("hinge", "slide"):
            raise InvalidInput(
                f"--drive {name}: it is a {joint.kind} joint; hinges and slides are driven: {listed(drivable)}"
            )
        laws[name] = law_of(text, joint.unit, float(tree.start[joint.coordinate]), name)
    if all(law.duration == math.inf for law in laws.values()):
        raise InvalidInput(
            f"none of its joints is driven: give --drive JOINT=LAW for one of {listed(drivable)}; LAW: {FORMS}"
        )
    seconds = question.seconds or _duration(laws)
    for name, law in laws.items():
        if (span := by_name[name].range) is not None:
            values = law.derivatives(np.linspace(0.0, seconds, 1001))[0]
            if values.min() < span[0] - 1e-9 or values.max() > span[1] + 1e-9:
                raise InvalidInput(
                    f"--drive {name}={law.text}: it goes from {values.min():.4g} to {values.max():.4g}, the joint's "
                    f"range is {span[0]:.4g} to {span[1]:.4g} {by_name[name].unit}"
                )
    return laws, tuple(
        joint.name for joint in tree.joints if joint.kind == "free" and not tree.bodies[joint.body].parent
    )


def _duration(laws: Mapping[str, Law]) -> float:
    return max(law.duration for law in laws.values() if law.duration < math.inf)


def _control_law(text: str, actuator: str) -> Callable[[float], float]:
    law = law_of(text, "rad", 0.0, actuator)
    return lambda now: float(law.derivatives(np.array([now]))[0, 0])


def _points(model: mujoco.MjModel, tree: SpatialTree, freedom: Mobility, question: Question) -> tuple[FoundPoint, ...]:
    """Points that are judged: those named, or all that the drives determine."""
    for name in question.points:
        if name not in tree.points:
            raise unknown_choice("point", name, tree.points)
        if name in freedom.undetermined:
            raise InvalidInput(
                f"--point {name}: its drives do not determine it: {', '.join(freedom.idle)} can still move"
            )
    return site_points(model, question.points or tuple(p for p in tree.points if p not in freedom.undetermined))


# -- kinematic mode --------------------------------------------------------------------------------------------------


def kinematic_mode(bench: _Bench, motion: SpatialMotion) -> tuple[dict[str, float], tuple[str, ...]]:
    """How far MuJoCo's kinematics are from the exact motion, over its largest values; and what is met on the way."""
    model, off, sizes = bench.model, dict.fromkeys(QUANTITIES, 0.0), dict.fromkeys(QUANTITIES, 0.0)
    data, opened, touching = mujoco.MjData(model), 0.0, dict[str, None]()
    start = {p.name: motion.points[p.name].position[0] for p in bench.points}
    for k in range(len(motion.times)):
        start_state(data, motion, k)
        with warnings_kept_quiet():
            mujoco.mj_forward(model, data)
        data.qacc[:] = motion.rates[1, :, k]
        mujoco.mj_rnePostConstraint(model, data)
        opened = max([opened, *gaps_of(model, data).values()])
        for contact in data.contact[: data.ncon]:
            if contact.dist < 0.0:
                touching[" and ".join(name_or_number(model, "geom", int(g)) for g in contact.geom)] = None
        for point in bench.points:
            exact = motion.points[point.name]
            for name, found in zip(QUANTITIES, point.motion(model, data), strict=True):
                truth = getattr(exact, name)[k]
                size = truth - start[point.name] if name == "position" else truth
                sizes[name] = max(sizes[name], float(np.linalg.norm(size)))
                off[name] = max(off[name], float(np.linalg.norm(found - truth)))
    shares = {name: off[name] / max(sizes[name], 1e-300) for name in QUANTITIES if sizes[name] > 1e-12}
    shares["closures"] = max(opened - 2.0 * bench.misfit, 0.0) / sizes["position"] if sizes["position"] else 0.0
    return shares, tuple(_met(bench, motion, list(touching)))


def _met(bench: _Bench, motion: SpatialMotion, touching: list[str]) -> Iterator[str]:
    if touching:
        yield f"parts touch on the way: {listed(touching)}; the runs have these contacts, the exact motion has none"
    for joint in bench.machine.tree.joints:
        if joint.range is not None and joint.kind in ("hinge", "slide"):
            values = motion.coordinates[joint.coordinate]
            if values.min() < joint.range[0] - 1e-6 or values.max() > joint.range[1] + 1e-6:
                yield (
                    f"{joint.name} goes from {values.min():.4g} to {values.max():.4g} {joint.unit}, its limits are "
                    f"{joint.range[0]:.4g} to {joint.range[1]:.4g}: the runs have them"
                )


# -- dynamic mode ----------------------------------------------------------------------------------------------------


def with_settings(model: mujoco.MjModel, label: str, step: float, period: float, idle: bool) -> mujoco.MjModel:
    """A copy with a preset's settings, or its own, at a step [s]; the solver goes on to the end, as flywheels need.

    Args:
        idle: whether the drives leave a freedom, whose inertia rounding hides beside closures that are too hard.
    """
    own = copy.copy(model)
    own.opt.timestep = step
    if label == OWN:
        return ordered(own, Order(label, tolerance=0.0))
    tuned = MuJoCoSettings("stock", 2, step).as_tuned(contact=False)
    if label == "hardened":
        tuned = replace(tuned, preset=label, solref=(0.1 * period, 1.0), hardening=SOFTER if idle else HARDENING)
    return ordered(own, Order(label, tuned))


def judged(
    label: str, step: float, run: Recording, motion: SpatialMotion, exact: SpatialForces | None, travel: float
) -> LoopRun:
    """A run with its errors against the exact motion at the same times."""
    gaps = {name: float(np.nanmax(gap)) for name, gap in run.gaps.items()}
    if run.outcome is not Outcome.COMPLETED:
        return LoopRun(label, step, run.outcome, run.reason, gaps=gaps)
    if max(gaps.values(), default=0.0) > OPEN_GAP * travel:
        worst = max(gaps, key=lambda name: gaps[name])
        return LoopRun(label, step, Outcome.OPENED, f"{worst} opens by {1e3 * gaps[worst]:.3g} mm", gaps=gaps)
    off = {
        name: np.linalg.norm(found - np.array([getattr(motion.points[name], q) for q in QUANTITIES]), axis=2)
        for name, found in run.points.items()
    }
    errors = {q: max(float(one[k].max()) for one in off.values()) for k, q in enumerate(QUANTITIES)}
    worst = max(off, key=lambda name: float(off[name][0].max()))
    drives, reactions = dict[str, float](), dict[str, float]()
    if exact is not None:
        drives = {name: _relative(run.forces[name], truth) for name, truth in exact.drives.items()}
        reactions = {name: _relative(run.forces[name], truth) for name, truth in exact.reactions.items()}
        reactions = {name: off for name, off in reactions.items() if math.isfinite(off)}
    curve = error_curve(run.times, np.max([one[0] for one in off.values()], axis=0))
    return LoopRun(label, step, Outcome.COMPLETED, "", errors, worst, curve, gaps, drives, reactions)


def _relative(found: Array, truth: Array) -> float:
    """Largest deviation over the largest of the truth; not a number where nothing of that is known."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return float(np.nanmax(np.abs(found - truth)) / max(float(np.nanmax(np.abs(truth))), 1e-300))


def _timed(advance: Callable[[int], None]) -> float:
    """CPU time of a step [s], over as many as take long enough to be timed."""
    count = 50
    while True:
        before = time.process_time()
        advance(count)
        if (spent := time.process_time() - before) > TIMED / 5:
            return spent / count
        count *= 2
