"""The study of a user's model against a scene: its paths, its own run, and its runs along its exact motion."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from conrod.comparison.compare import ExactMotions, size_of, track_errors
from conrod.comparison.other_forces import add_obstacles
from conrod.comparison.outcome import MAX_CONTACT_GAP, MAX_JOINT_GAP, MAX_REACH_SIZES, RunVerdict
from conrod.comparison.trajectory import Outcome, PointTracks, Track
from conrod.errors import InvalidInput
from conrod.exact.kinematics import ExactReference
from conrod.exact.motion import QUANTITIES, Array, Instants
from conrod.exact.space.drive_laws import parse_drive_law
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.execution.prediction import reference_misfit
from conrod.execution.resolve_arguments import MAX_KEPT_SAMPLES
from conrod.execution.result import misfit_words
from conrod.execution.tolerances import Limit, scale_tolerance, scene_scales
from conrod.mjcf.causes import add_causes_to_errors, append_causes, describe_closures
from conrod.mjcf.crank_speed import CrankSpeed
from conrod.mjcf.driven_runs import is_on_other_branch, with_settings
from conrod.mjcf.driving import LoopRecording, driven_run, record_run
from conrod.mjcf.loading import data_at_start
from conrod.mjcf.loop_results import LABELS
from conrod.mjcf.request import MIN_NAMED_OPENING, ModelRequest
from conrod.mjcf.unit_of_length import controls_in_metres
from conrod.models.check.drawing import draw_scene_runs, draw_turn
from conrod.models.check.frame import Frame, GivenFrame
from conrod.models.check.identity import identify, unknown_identity
from conrod.models.check.references import returns_after_turn
from conrod.models.check.results import OWN_RUN, JudgedRun, ModelStudy
from conrod.models.check.scanning import model_facts, scan
from conrod.models.check.scene_causes import causes_besides, refusal_causes, scene_causes
from conrod.models.check.turning import BlockedTurnError, Turning, prepare_turning
from conrod.scenes import Scene
from conrod.studies.validation.results import RefinementPoint
from conrod.user_files.files import name_file_in_errors

STEP_REFINEMENTS = (0.5, 2.0, 4.0)  # steps that take the place of one, where a model is refined
# A model whose points are further off than this, with all lengths fitted, is another machine: its runs say nothing.
MAX_COMPARABLE_DISTANCE = 0.05


def study_scene_model(
    path: Path,
    scene: tuple[str, Scene],
    question: ModelRequest,
    given: GivenFrame,
    revolutions: float,
    tolerance: Mapping[str, Limit] | None,
    refine: bool = False,
    qualify: bool = False,
) -> ModelStudy:
    """Judge a model file against a scene; call it in a separate process (`conrod.execution.local`).

    Args:
        scene: its name and itself.
        refine: whether the runs that conrod drives are made at other steps, too.
        qualify: whether known defects are planted into a check that has passed.

    Raises:
        InvalidInput: the model cannot be used, its plane of motion or its frame cannot be determined, or its runs
            cannot be made.
    """
    with name_file_in_errors(path):
        name, machine = scene
        question = replace(question, span=machine.mechanism().driver.span, returns=returns_after_turn(machine))
        with add_causes_to_errors(path, lambda model: refusal_causes(model, scene, question), question.unit):
            try:
                turning = prepare_turning(path, question)
            except BlockedTurnError as error:
                if not list(scene_causes(error.turning.model, scene, question)):
                    raise
                return _blocked_study(path, scene, question, error, revolutions)
            inputs = controls_in_metres(turning.model, question.controls, question.unit)
            question = replace(question, controls=inputs)
            scanned = scan(turning, question)
            facts, (identity, moving) = scanned.facts, identify(machine, scanned, given)
        misplaced = identity.explanations[0].misplaced if identity.explanations else ()
        wrong = {one.point for one in misplaced}
        # Compared are points that are where they should be on their links; all, where none is.
        points = tuple(point for point in scanned.points if point not in wrong) or scanned.points
        distrust = misfit_words(reference_misfit(machine))
        limits, weights = scale_tolerance(tolerance or {}, scene_scales(machine) if tolerance else {})
        if "total" not in limits and "position" in weights:
            weights["total"] = weights["position"]
        allowed = None if tolerance is None else limits
        parts = (str(path), name, machine, question, facts, identity, allowed, revolutions)
        found = ModelStudy(*parts, {}, {}, points, distrust=distrust, weights=weights)
        besides = causes_besides(turning.model, scene, question, identity, given, is_machine=found.is_machine)
        found = replace(
            found, model=replace(facts, about="; ".join(filter(None, (facts.about, *besides, *turning.left_out))))
        )
        if identity.left > MAX_COMPARABLE_DISTANCE:
            return replace(found, drawn=draw_turn(turning))
        bench = ModelBench(turning, question, moving, machine.speed, identity.frame, points, revolutions)
        refused = {"hardened": "hardening does not apply to contact"} if question.contacts else {}
        recorded = {label: bench.record_driven(label) for label in LABELS if label not in refused}
        at_steps = {label: [bench.judge(label, *one)] for label, one in recorded.items()}
        drawn = draw_scene_runs(
            turning, [same[0] for same in at_steps.values()], {label: run for label, (run, _) in recorded.items()},
            bench.period,
        )  # fmt: skip
        for refinement in STEP_REFINEMENTS if refine else ():
            if bench.sample_count(facts.timestep / refinement) <= MAX_KEPT_SAMPLES:
                for label, same in at_steps.items():
                    same.append(bench.run_driven(label, refinement))
        own_run, crank = bench.run_as_given()
        refined = {label: _refinement_points(same) for label, same in at_steps.items() if len(same) > 1}
        runs = {label: same[0] for label, same in at_steps.items()}
        found = replace(found, own_run=own_run, crank=crank, runs=runs, refused=refused, refined=refined, drawn=drawn)
        if not qualify or not found.passed:
            return found
        from conrod.models.check.qualification import qualify_check

        return replace(found, qualified=qualify_check(found, scanned, given, bench))


def _blocked_study(
    path: Path, scene: tuple[str, Scene], question: ModelRequest, error: BlockedTurnError, revolutions: float
) -> ModelStudy:
    """The study of a model that cannot turn as the machine does, and differs from it."""
    turning = error.turning
    causes = refusal_causes(turning.model, scene, question)
    words = append_causes(str(error), describe_closures(turning.model), *causes)
    facts, unknown = replace(model_facts(turning, question), about=""), unknown_identity(question.unit)
    found = ModelStudy(str(path), *scene, question, facts, unknown, None, revolutions, {}, {}, (), blocked=words)
    return replace(found, drawn=draw_turn(turning, as_far_as_it_goes=True))


def _refinement_points(runs: list[JudgedRun]) -> tuple[RefinementPoint, ...]:
    """Errors of runs with one setting, from coarse to fine steps."""
    ordered = sorted(runs, key=lambda run: run.steps_per_revolution)
    return tuple(
        RefinementPoint(round(run.steps_per_revolution), run.outcome.slug, *(run.worst(name) for name in QUANTITIES))
        for run in ordered
    )


@dataclass(frozen=True, eq=False)
class ModelBench:
    """A model to run with its crank driven at a scene's speed, or as its file drives it.

    Attributes:
        exact: the machine that the model is.
        speed: nominal, of the crank angle [rad/s].
        frame: in which runs are seen.
        points: points that are compared.
    """

    turning: Turning
    question: ModelRequest
    exact: ExactReference
    speed: float
    frame: Frame
    points: tuple[str, ...]
    turns: float

    @property
    def period(self) -> float:
        return 2.0 * math.pi / abs(self.speed)

    @property
    def _begin(self) -> float:
        """Crank angle [rad] at which conrod's runs begin."""
        span = self.question.span
        return 0.0 if span is None else span[0] if self.speed > 0.0 else span[1]

    def sample_count(self, step: float, begin: float | None = None) -> int:
        """Number of samples of a run, whose steps [s] need not divide a turn.

        Args:
            begin: crank angle [rad] at which one pass begins; None for its own begin.
        """
        span = self.question.span
        if span is None:
            return max(2, math.ceil(self.turns * self.period / step - 1e-9)) + 1
        way = (span[1] - begin if self.speed > 0.0 else begin - span[0]) if begin is not None else math.inf
        # No step goes beyond the end of the pass.
        return max(2, math.floor(min(max(way, 0.0), self.question.width) / abs(self.speed) / step + 1e-6)) + 1

    def _times(self, step: float, begin: float | None = None) -> Array:
        """Instants of a run [s]; raises InvalidInput where they are too many."""
        samples = self.sample_count(step, begin)
        if samples > MAX_KEPT_SAMPLES:
            raise InvalidInput(
                f"its timestep of {step:g} s makes {samples} samples of {self.turns:g} turns: "
                f"at most {MAX_KEPT_SAMPLES} are kept; fewer --revolutions"
            )
        return np.asarray(step * np.arange(samples), dtype=float)

    def run_driven(self, label: str, refinement: float = 1.0) -> JudgedRun:
        """Run driven, by a preset or as the model is, with `refinement` times as many steps; return its errors."""
        return self.judge(label, *self.record_driven(label, refinement))

    def record_driven(self, label: str, refinement: float = 1.0) -> tuple[LoopRecording, float]:
        """Run driven, by a preset or as the model is, with `refinement` times as many steps; return its step [s]."""
        turning, step = self.turning, float(self.turning.model.opt.timestep) / refinement
        model = with_settings(turning.model, label, step, self.period, contact=bool(self.question.contacts))
        elapsed = turning.time_at(self.frame.zero + self.frame.sense * self._begin)
        rate, crank = self.frame.sense * self.speed, turning.crank.name
        law = parse_drive_law(f"{rate!r}rad/s", "rad", turning.first + elapsed, crank)
        coordinates, rates = turning.state(elapsed)
        start = coordinates[:, None], rate * np.array([rates, 0.0 * rates, 0.0 * rates])[:, :, None]
        machine, motion = DrivenTree(turning.machine.tree, {crank: law}), SpatialMotion(self._times(step), *start, {})
        run = driven_run(machine, model, motion, turning.points, 1, carried=False, touching=turning.touching)
        return run, step

    def run_as_given(self) -> tuple[JudgedRun, CrankSpeed | None]:
        """Run the file as it is: its start, actuators, controls and autoreset."""
        model, turning = self.turning.model, self.turning
        data, _ = data_at_start(model, self.question.keyframe, self.question.controls)
        step = float(model.opt.timestep)
        times = self._times(step, float(self.frame.angle(data.qpos[turning.crank.coordinate])))
        run, _ = record_run(turning.machine.tree, model, data, turning.points, times, touching=turning.touching)
        found = self.judge(OWN_RUN, run, step)
        if found.outcome is not Outcome.COMPLETED:
            return found, None
        # The crank in the last turn's time, or in all of it where that is less.
        at, last = self.instants(run), run.times >= run.times[-1] - self.period * (1.0 + 1e-9)
        angle, rate = at.angle[last], at.rate[last]
        mean = float(angle[-1] - angle[0]) / max(step * (len(angle) - 1), 1e-300)
        farthest = float(np.abs(at.angle - at.angle[0]).max()) / (2.0 * math.pi)
        crank = CrankSpeed(mean, float(rate.min()), float(rate.max()), farthest)
        # What stands in a closed pose is exact there, which says nothing of a motion.
        closed = (
            max((float(gap[0]) for gap in self.machine_gaps(run)), default=0.0)
            <= MIN_NAMED_OPENING * turning.machine.tree.extent
        )
        stands = crank.is_still and closed
        return (replace(found, errors=None) if stands else found), crank

    def machine_gaps(self, run: LoopRecording) -> list[Array]:
        """Violations (K,) [m] of the closures that the crank moves; what else the file ties together is not judged."""
        machine = self.turning.machine.tree.closures_linked_to(self.turning.crank)
        return [gap for name, gap in run.violations.items() if name in machine]

    def instants(self, run: LoopRecording) -> Instants:
        """Times, crank angle and its rates, in the document's frame."""
        crank, sense = self.turning.crank, self.frame.sense
        rates, angle = (run.rates[crank.rate], run.accelerations[crank.rate]), run.coordinates[crank.coordinate]
        angle = self.frame.angle(angle)
        # The clock of one pass is at 0 where the crank angle is, which may lie beside the pass.
        times = run.times if self.question.span is None else run.times + angle[0] / self.speed
        return Instants(times, angle, *(sense * one for one in rates))

    def judge(self, label: str, run: LoopRecording, step: float) -> JudgedRun:
        """Determine the outcome and the errors of a run."""
        at = self.instants(run)
        # The scene's clock begins at crank angle 0, which the file need not start at; that of one pass does so already.
        if label == OWN_RUN and self.question.span is None:
            at = replace(at, times=at.times + at.angle[0] / self.speed)
        seen = (self.frame.document_positions, self.frame.document_vectors, self.frame.document_vectors)
        tracks = {
            name: PointTracks(*(Track(at, see(v)) for see, v in zip(seen, run.points[name], strict=True)))
            for name in self.points
        }
        verdict, errors = RunVerdict(run.outcome, run.reason), None
        gap = max((float(gap.max()) for gap in self.machine_gaps(run)), default=0.0)
        opening = self.frame.unit * gap / max(self.exact.lengths.values())
        if run.outcome is Outcome.COMPLETED:
            verdict = next(self._failures(run, tracks), verdict)
        if verdict.outcome is Outcome.COMPLETED:
            errors = {
                name: {quantity: size_of(series.error) for quantity, series in vars(found).items()}
                for name, found in track_errors(tracks, self.speed, ExactMotions(self.exact)).items()
            }
        phase = float(np.abs(at.angle - at.angle[0] - self.speed * run.times).max())
        acting = tuple(one.in_metres(self.frame.unit) for one in run.acting)
        reason = add_obstacles(verdict.reason, acting)
        return JudgedRun(label, verdict.outcome, reason, self.period / step, errors, phase, acting, opening)

    def _failures(self, run: LoopRecording, tracks: Mapping[str, PointTracks]) -> Iterator[RunVerdict]:
        """Yield failures that points and violations show, though the engine completed the run; the first counts.

        A run that starts open and snaps shut goes on from there: how far it was open is an error of it, no outcome.
        """
        travel, exact = max(self.exact.lengths.values()), ExactMotions(self.exact)
        places = np.array([t.position.values for t in tracks.values()])
        off = np.array([exact.error(t.position, name, "position") for name, t in tracks.items()])
        away = np.abs(places - places[:, :1]).max(axis=(0, 2)) / self.exact.kinematics.size
        if away.max() > MAX_REACH_SIZES:
            time = run.times[int(np.argmax(away > MAX_REACH_SIZES))]
            yield RunVerdict(
                Outcome.EXPLODED, f"beyond {MAX_REACH_SIZES:g} sizes of the mechanism from {time:.6g} s on"
            )
        if self.turning.touching is not None:
            # A follower further from the crank's axis than the cam would have it, or nearer by a roller.
            from_axis = places - np.array(self.frame.shaft)
            outward = (off * from_axis).sum(axis=2) / np.linalg.norm(from_axis, axis=2)
            contacts = self.exact.mechanism().cam_contacts
            if contacts and outward.min() < -contacts[0].roller_radius:
                yield RunVerdict(Outcome.TUNNELLED, f"the roller is {-outward.min():.3g} m deep in the cam")
            if outward.max() > MAX_CONTACT_GAP * travel:
                yield RunVerdict(Outcome.LOST_CONTACT, f"the follower is up to {outward.max():.3g} m off the cam")
        late = len(run.times) // 2
        opened = max((max(*(gap - gap[0]), *gap[late:]) for gap in self.machine_gaps(run)), default=0.0)
        if self.frame.unit * opened > MAX_JOINT_GAP * travel:
            yield RunVerdict(Outcome.OPENED, f"a closure is open by up to {1e3 * self.frame.unit * opened:.3g} mm")
        worst = int(np.argmax(size := np.linalg.norm(off, axis=2).max(axis=0)))
        if size[worst] > MAX_JOINT_GAP * travel and self.turning.touching is None:
            machine, there = self.turning.machine, run.coordinates[:, worst : worst + 1]
            coordinate, near = float(there[self.turning.crank.coordinate, 0]), MAX_JOINT_GAP * travel
            time, here = (
                coordinate - self.turning.first,
                self.turning.state(self.turning.time_at(coordinate))[0][:, None],
            )
            if is_on_other_branch(machine, machine.tree.points, there, time, here, near / self.frame.unit):
                starts = "it starts so, and is " if size[0] > MAX_JOINT_GAP * travel else ""
                far = f"{starts}up to {1e3 * size[worst]:.3g} mm off"
                yield RunVerdict(Outcome.FLIPPED, f"on another branch {machine.describe_drives(round(time, 9))}, {far}")
