"""The study of a model's closed loops: its exact motion, MuJoCo's kinematics, its runs and the cheapest settings."""

from __future__ import annotations

import copy
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from pathlib import Path

import mujoco
import numpy as np

from conrod.comparison.other_forces import OtherForce, add_obstacles, merge_forces
from conrod.comparison.outcome import MAX_JOINT_GAP
from conrod.comparison.trajectory import Outcome
from conrod.errors import InvalidInput, OutsideLoopsError, list_names
from conrod.exact.motion import Array
from conrod.exact.space import SpatialTree
from conrod.exact.space.immobility import describe_corrections, explain_immobility
from conrod.exact.space.mobility import Mobility, SpatialForces, forces
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.execution.paired_timing import PairedTiming, time_stepper_pair
from conrod.mjcf.causes import append_causes, describe_closures
from conrod.mjcf.differences import NUMBER_TOLERANCE, MachineComparison, compare_with_machine, list_differences
from conrod.mjcf.drawn_links import draw_judged_runs
from conrod.mjcf.driven_runs import compare_kinematics, judge_run, shipped_run, with_settings
from conrod.mjcf.driving import driven_run, set_exact_state
from conrod.mjcf.edits import Recipe, apply_recipe
from conrod.mjcf.equalities import inactive_closures, inactive_words
from conrod.mjcf.loading import OWN_POSE, FoundPoint, check_finite, data_at_start, start_words
from conrod.mjcf.loop_results import (
    FEWEST_STEPS,
    LABELS,
    OWN_SETTINGS,
    LoopRequest,
    LoopRun,
    LoopStudy,
    SettingsSearch,
    ShippedRun,
)
from conrod.mjcf.missing_files import load_with_notes
from conrod.mjcf.reading import check_rigid, duration, laws_of, machine_tree, tree_of
from conrod.mjcf.request import OpenStart
from conrod.mjcf.runs import looping_stepper, state_of
from conrod.mjcf.start import open_start
from conrod.mjcf.unit_of_length import controls_in_metres
from conrod.models.loops.law_comparison import allowed_speed_error, compare_with_laws
from conrod.models.loops.load_differences import list_load_differences
from conrod.models.loops.search import order_of, search_settings
from conrod.models.loops.settings import SEARCHED, after_compiling, mjcf_lines, python_lines, settings_edits
from conrod.models.loops.tracking import MAX_SEARCHED_JOINTS, choose_points, motion_scales, moved_points, track_motion
from conrod.report.drawing.moving_links import MovingLinks
from conrod.scenes.space import MACHINES

# Divisors of the model's number of steps; factors on it, where longer steps show no order. Samples that a run keeps.
FINER, COARSER, MAX_SAMPLES = (2, 4), (2, 4), 500
KEPT_MOTIONS = 1 + len(FINER) + len(COARSER)
CHECKED_INSTANTS, MAX_STEPS = 180, 10**6
# Of runs that search for settings: steps at most, and the finest step, as a power of two of the model's own.
MAX_SEARCHED_STEPS, FINEST = 50_000, -6
LONGEST_TIMING = 0.5  # [s] of a pair of settings, where the CPU time is limited


def study_loops(
    path: Path, question: LoopRequest, name: str, step_factor: float = 1.0,
    bears: Callable[[mujoco.MjModel], bool] = lambda model: True,
) -> LoopStudy:  # fmt: skip
    """Judge the loops of a model file; call it in a separate process (`conrod.execution.local`).

    Args:
        step_factor: factor on the model's time step; differs from 1 by last bits alone, to measure rounding.
        bears: whether the actuators of the model bear settings that hold its tolerance.

    Raises:
        InvalidInput: the model cannot be used, its drives are too few or too many, or its loops cannot be closed.
    """
    model, left_out = load_with_notes(path, question.unit)
    question = replace(question, controls=controls_in_metres(model, question.controls, question.unit))
    against, found = "", list[str]()
    model.opt.timestep *= step_factor
    try:
        check_finite(model)
        check_rigid(model)
        machine = None if question.machine is None else machine_tree(question.machine)
        if machine is not None:
            start = data_at_start(model, question.keyframe or OWN_POSE)[0].qpos
            found = list(list_differences(tree_of(model, start), machine, inactive_closures(model)))
            against = f"; against {question.machine}: {'; '.join(found) or 'no difference is found'}"
        bench = _LoopBench.from_request(model, question, explained=bool(found or describe_closures(model)))
        study = replace(bench, bears=bears).study(str(path), name, machine)
        return replace(study, remarks=(*study.remarks, *left_out))
    except InvalidInput as error:
        words = append_causes(str(error).removeprefix(f"{path}: "), describe_closures(model))
        outside = isinstance(error, OutsideLoopsError) and question.machine is None
        raise (OutsideLoopsError if outside else InvalidInput)(f"{path}: {words}{against}") from None


@dataclass(frozen=True, eq=False)
class _LoopBench:
    """A model with its exact machine, assembled and driven.

    Attributes:
        moved_start: as in `LoopStudy`.
        begun: CPU time of the process before it was assembled [s].
        bears: as in `study_loops`.
    """

    model: mujoco.MjModel
    question: LoopRequest
    machine: DrivenTree
    data: mujoco.MjData
    seconds: float
    freedom: Mobility
    points: tuple[FoundPoint, ...]
    moved_start: str = ""
    begun: float = field(default_factory=time.process_time)
    bears: Callable[[mujoco.MjModel], bool] = lambda model: True

    @classmethod
    def from_request(cls, model: mujoco.MjModel, question: LoopRequest, *, explained: bool = False) -> _LoopBench:
        (data, key), begun = data_at_start(model, question.keyframe or OWN_POSE), time.process_time()
        tree = tree_of(model, data.qpos)
        if not tree.closures:
            off = inactive_words(model)
            # Closures that are switched off are a slip; without any, its actuators and joints are looked at instead.
            raise (InvalidInput if off else OutsideLoopsError)(f"it has no closed loop{f': {off}' if off else ''}")
        laws, held = laws_of(model, tree, question)
        seconds, step = question.seconds or duration(laws), float(model.opt.timestep)
        if not 2.0 * step <= seconds <= MAX_STEPS * step:
            most = f"from 2 to {MAX_STEPS:,} can be run"
            raise InvalidInput(f"{seconds:g} s are {seconds / step:.3g} of its time steps of {step:g} s: {most}")
        machine = DrivenTree(tree, laws, held)
        moved_start = track_motion(machine, seconds, start_words(model, key), explained)
        freedom, points = choose_points(model, machine, question)
        return cls(model, question, machine, data, seconds, freedom, points, moved_start=moved_start, begun=begun)

    @property
    def period(self) -> float:
        """Time [s] that the slowest drive takes for its law."""
        return duration(self.machine.laws)

    def study(self, file: str, name: str, machine: SpatialTree | None) -> LoopStudy:
        """Run and compare everything; return the study."""
        checked = self.machine.motion(np.linspace(0.0, self.seconds, CHECKED_INSTANTS))
        ways = {n: float(np.linalg.norm(p.position - p.position[0], axis=1).max()) for n, p in checked.points.items()}
        least, judged = 1e-9 * self.machine.tree.extent, [point.name for point in self.points]
        if (travel := max(ways[name] for name in judged)) <= least:
            moving = [name for name, way in ways.items() if way > least and name not in self.freedom.undetermined]
            others = f"; --point NAME takes {list_names(moving)}" if moving else ""
            raise InvalidInput(f"no judged point moves with these drives: {', '.join(judged)}{others}")
        scales = motion_scales([checked.points[name] for name in judged])
        return replace(self, question=self.question.in_si(scales))._study_motion(
            file, name, machine, checked, travel, scales
        )

    def _study_motion(
        self,
        file: str,
        name: str,
        machine: SpatialTree | None,
        checked: SpatialMotion,
        travel: float,
        scales: Mapping[str, float],
    ) -> LoopStudy:
        """Compare a motion that was sampled at `CHECKED_INSTANTS`; return the study.

        Args:
            travel: largest distance [m] that a judged point moves from its start.
            scales: as in `LoopStudy`.
        """
        shipped = self._run_as_shipped(travel)  # what is wrong with controls is said before the runs
        shipped = self._compare_with_laws(shipped, checked, travel)
        kinematic, remarks = compare_kinematics(self.model, self.machine, self.points, checked)
        runs, steps, drawn = self._runs(travel)
        unknown = self._unknown_forces(merge_forces(one for run in runs for one in run.acting))
        exact = None if unknown else forces(self.machine, checked)
        search, paste = self._search(Path(file), travel, scales, shipped, (*runs, *steps))
        return LoopStudy(
            file, name, mujoco.__version__, self.question, self.seconds, travel, self.machine.held, self.freedom,
            self.machine.misfit, kinematic, () if exact is None else exact.indeterminate, unknown, remarks,
            shipped, runs, steps, None if search is None else search.best, paste,
            self._compare_with_machine(machine, checked, travel),
            {label: self._run_as_shipped(travel, label) for label in LABELS[1:] if self._has_time()},
            self._open_start(), self.moved_start, self._closure_words(),
            tuple(point.name for point in self.points), scales=scales, search=search,
            moved=moved_points(self.model, self.machine, self.freedom, self.question), drawn=drawn,
        )  # fmt: skip

    def _closure_words(self) -> str:
        """Describe closures, and the axis or anchor that makes them contradict each other, if they do."""
        machine, said = self.machine, describe_closures(self.model)
        closes = machine.misfit <= NUMBER_TOLERANCE * machine.tree.extent
        if closes or self.question.machine is not None or len(machine.tree.loop_joints) > MAX_SEARCHED_JOINTS:
            return said
        found = explain_immobility(machine.tree, machine.laws, machine.held, machine.knots[0].coordinates)
        return f"{said}{'; ' if said else ''}its closures contradict each other: {describe_corrections(found)}"

    def _open_start(self) -> OpenStart | None:
        """Closures that are open where the file's own run starts; None if all are closed."""
        data, key = data_at_start(self.model, self.question.keyframe, self.question.controls)
        return open_start(self.model, data, self.machine.tree.extent, start_words(self.model, key))

    def _compare_with_machine(
        self, machine: SpatialTree | None, motion: SpatialMotion, travel: float
    ) -> MachineComparison | None:
        """Compare the model with the requested machine, and with its closed form, if any."""
        if machine is None or (name := self.question.machine) is None:
            return None
        driven = self.machine
        off = inactive_closures(self.model)
        found = compare_with_machine(name, driven.tree, machine, driven.laws, driven.held, motion, off, driven)
        found = replace(found, loads=tuple(list_load_differences(driven.tree, machine)))
        if name not in MACHINES:
            return found
        laws = {joint: law.derivatives(motion.times)[:3] for joint, law in driven.laws.items()}
        exact = MACHINES[name]().points(laws)
        apart = (np.abs(exact[p][0] - motion.points[p].position).max() for p in exact if p in motion.points)
        return replace(found, closed_form=max(map(float, apart)) / travel)

    def _unknown_forces(self, acting: tuple[OtherForce, ...]) -> tuple[str, ...]:
        """Forces and inertias that the exact forces do not include, in words."""
        spins = (f"{', '.join(self.freedom.idle)} idle, whose spin no drive determines",) if self.freedom.idle else ()
        return (*self.machine.tree.unmodelled, *spins, *(one.title for one in acting if not one.exact))

    # -- runs ---------------------------------------------------------------------------------------------------------

    def _runs(self, travel: float) -> tuple[tuple[LoopRun, ...], tuple[LoopRun, ...], MovingLinks | None]:
        """Runs at the model's own step, with order and cost, runs at other steps, and the first ones in motion."""
        at_own, others, recorded = list[LoopRun](), list[LoopRun](), dict[str, Array]()
        costs = self._costs()
        for label in LABELS:
            made = {n: self._run(label, n, travel, recorded) for n in dict.fromkeys(1.0 / c for c in (1, *COARSER))}
            if (found := order_of(made)).claimed is None and found.plateau is None:
                made |= {float(n): self._run(label, float(n), travel, recorded) for n in FINER}
                found = order_of(made)
            priced = {n: replace(run, cost=costs[label] * n) for n, run in made.items()}
            at_own.append(replace(priced[1.0], order=found.claimed))
            others += [run for n, run in priced.items() if n != 1.0]
        step, count = float(self.model.opt.timestep), int(self.seconds / float(self.model.opt.timestep) + 1e-9)
        exact = self._motion_at(step, count, max(1, count // MAX_SAMPLES)) if recorded else None
        drawn = None if exact is None else draw_judged_runs(self.model, exact, self.points, at_own, recorded)
        return tuple(at_own), tuple(others), drawn

    def _run(self, label: str, refinement: float, travel: float, recorded: dict[str, Array]) -> LoopRun:
        """Run with `refinement` times as many steps as the model's own, compared with the exact motion.

        Args:
            recorded: takes the coordinates (nq, K) of a run at the model's own step, by its label.
        """
        step = float(self.model.opt.timestep) / refinement
        count = int(self.seconds / step + 1e-9)
        if not 2 <= count <= MAX_STEPS:
            return LoopRun(label, step, Outcome.UNSUPPORTED, f"{count} steps: 2 to {MAX_STEPS:,} are made")
        if refinement != 1.0 and not self._has_time():
            return LoopRun(label, step, Outcome.UNSUPPORTED, f"not made: {self.question.cpu_time:g} s were over")
        run, coordinates = self._record_model(label, self._with_settings(label, step), travel)
        if refinement == 1.0:
            recorded[label] = coordinates
        return run

    def _record_model(self, label: str, model: mujoco.MjModel, travel: float) -> tuple[LoopRun, Array]:
        """Run a model with the settings of a label, compared with the exact motion; return its coordinates (nq, K)."""
        step = float(model.opt.timestep)
        count = int(self.seconds / step + 1e-9)
        every = max(1, count // MAX_SAMPLES)
        motion = self._motion_at(step, count, every)
        recorded = driven_run(self.machine, model, motion, self.points, every)
        exact = None if self._unknown_forces(recorded.acting) else self._forces_along(motion)
        found = judge_run(label, step, recorded, motion, self.machine, exact, travel)
        found = replace(found, acting=recorded.acting, reason=add_obstacles(found.reason, recorded.acting))
        return found, recorded.coordinates

    # Runs of all presets have the same samples, so that the exact motion there is the same.

    @cached_property
    def _motion_at(self) -> Callable[[float, int, int], SpatialMotion]:
        """Function that returns the exact motion at each `every`-th of `count` steps [s]."""

        @lru_cache(KEPT_MOTIONS)
        def motion_at(times: bytes) -> SpatialMotion:
            return self.machine.motion(np.frombuffer(times).copy())

        # Half of the steps with every second sample have the same times, to the last bit.
        return lambda step, count, every: motion_at((step * np.arange(0.0, count + 1.0, every)).tobytes())

    @cached_property
    def _forces_along(self) -> Callable[[SpatialMotion], SpatialForces]:
        """Function that returns the forces along an exact motion."""
        return lru_cache(KEPT_MOTIONS)(partial(forces, self.machine))

    def _with_settings(self, label: str, step: float) -> mujoco.MjModel:
        return with_settings(self.model, label, step, self.period, idle=bool(self.freedom.idle))

    def _has_time(self) -> bool:
        """True while further runs may be made."""
        return self.question.cpu_time is None or time.process_time() - self.begun <= self.question.cpu_time

    def _costs(self) -> dict[str, float]:
        """Cost of a step with each preset over one with the model's own settings, timed alternately."""
        step = float(self.model.opt.timestep)
        return {OWN_SETTINGS: 1.0} | {label: self._time(self._with_settings(label, step)).ratio for label in LABELS[1:]}

    def _time(self, model: mujoco.MjModel) -> PairedTiming:
        """Time a step of a model against one of the file's, alternately; both from the start of the exact motion."""
        start, steppers = self.machine.motion(np.zeros(1)), []
        for one in (copy.copy(model), copy.copy(self.model)):
            one.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION  # in the runs the drives hold against it
            data = mujoco.MjData(one)
            set_exact_state(data, start)
            steppers.append(looping_stepper(one, state_of(one, data), 100))
        return time_stepper_pair(*steppers, longest=math.inf if self.question.cpu_time is None else LONGEST_TIMING)

    def _search(
        self,
        path: Path,
        travel: float,
        scales: Mapping[str, float],
        shipped: ShippedRun,
        known: tuple[LoopRun, ...],
    ) -> tuple[SettingsSearch | None, str]:
        """Search for the cheapest settings within the tolerance; return the search and MJCF to paste.

        Args:
            path: the model's file.
            scales: as in `LoopStudy`.
            shipped: the file's own run as it is.
            known: runs with the presets, from whose steps the search begins.
        """
        share = self.question.searched_share
        allowed = self.question.tolerance or ({"position": share * scales["position"]} if share else {})
        if not allowed:
            return None, ""
        own_step = float(self.model.opt.timestep)
        longest, bearable = self.seconds / FEWEST_STEPS, self.question.largest_step or math.inf
        borne = bearable < longest
        most = math.floor(math.log2(min(longest, bearable) / own_step) + 1e-9)
        least = max(FINEST, math.ceil(math.log2(self.seconds / (MAX_SEARCHED_STEPS * own_step))))
        guesses = dict.fromkeys(SEARCHED, 0)
        for label in LABELS:
            within = [run.timestep for run in known if run.label == label and run.is_within(allowed)]
            tried = [run.timestep for run in known if run.label == label]
            guesses[label] = round(math.log2((max(within) if within else min(tried)) / own_step))

        def edits(name: str, step: float) -> Recipe:
            return settings_edits(self.model, name, step, self.period, idle=bool(self.freedom.idle))

        def run_at(name: str, step: float) -> tuple[LoopRun, ShippedRun]:
            model = apply_recipe(self.model, edits(name, step))
            run = self._record_model(name, model, travel)[0]
            if run.is_within(allowed) and not self.bears(model):
                run = replace(run, outcome=Outcome.UNSUPPORTED, reason="its actuators do not bear it")
            return run, self._run_shipped(model, travel)

        def timing_of(name: str) -> PairedTiming:
            return self._time(apply_recipe(self.model, edits(name, own_step)))

        limits = min(least, 0), max(most, 0)
        found = search_settings(
            run_at, timing_of, guesses, allowed, own_step, limits, own=shipped, may_go_on=self._has_time
        )
        found = replace(found, borne=borne, ended=None if self._has_time() else self.question.cpu_time)
        if (best := found.best) is None:
            return found, ""
        recipe = edits(best.label, best.timestep)
        found = replace(found, python=python_lines(recipe), after_compiling="\n".join(after_compiling(recipe)))
        return found, mjcf_lines(path, self.model, recipe)

    def _run_as_shipped(self, travel: float, label: str = OWN_SETTINGS) -> ShippedRun:
        """Run the file as it is, with the requested controls.

        Args:
            travel: largest distance [m] that a judged point moves from its start.
            label: `OWN_SETTINGS`, or the preset whose settings replace those of the file.
        """
        own = label == OWN_SETTINGS
        model = copy.copy(self.model) if own else self._with_settings(label, float(self.model.opt.timestep))
        return self._run_shipped(model, travel)

    def _run_shipped(self, model: mujoco.MjModel, travel: float) -> ShippedRun:
        """Run a model with the file's actuators and the requested controls."""
        data, key = data_at_start(self.model, self.question.keyframe, self.question.controls)
        words = start_words(self.model, key, data.ctrl.tolist())
        return shipped_run(self.machine.tree, model, data, self.seconds, words, travel)

    def _compare_with_laws(self, shipped: ShippedRun, motion: SpatialMotion, travel: float) -> ShippedRun:
        """Compare a driven, completed run of the file with the drives' laws, and add the result."""
        if not shipped.driven or shipped.failed:
            return shipped
        data, _ = data_at_start(self.model, self.question.keyframe, self.question.controls)
        names = [point.name for point in self.points]
        fastest = max(float(np.linalg.norm(motion.points[name].velocity, axis=1).max()) for name in names)
        allowed = allowed_speed_error(self.question.tolerance, travel, fastest)
        near = MAX_JOINT_GAP * travel
        compared = compare_with_laws(self.machine, self.model, data, names, self.seconds, allowed, near)
        return replace(shipped, laws=compared)
