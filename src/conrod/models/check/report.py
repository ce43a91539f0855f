"""The report on a user's model: its findings in sentences and its runs, for console and page."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from conrod.comparison.other_forces import acting_sentences
from conrod.comparison.trajectory import Outcome
from conrod.exact.motion import QUANTITIES
from conrod.mechanism.units import MM
from conrod.mjcf.request import LENGTH_UNITS
from conrod.models.check.identity import Explanation, FoundLength
from conrod.models.check.references import ALL_LENGTHS
from conrod.models.check.results import JudgedRun, ModelStudy
from conrod.report.kind import Kind, Part
from conrod.report.numbers import (
    IN_MM,
    in_mm,
    in_shown_unit,
    measured_text,
    quantity,
    round_to_digits,
    unequal_quantities,
    with_mm,
)
from conrod.report.results import distrust_words, exceeded_words
from conrod.report.table import Table, table
from conrod.report.terminal import PrintedPart, indented_under, verdict_line
from conrod.scenes import Scene
from conrod.studies.validation.tables import noticed_table

RIGHT_COLUMNS = ("steps/rev", "position", IN_MM, *QUANTITIES[1:])
OF_ITS_TRAVEL = " of its travel"
MAX_EXPLANATIONS = 4
JOINT_NAMES = {"Revolute": "pin", "Prismatic": "slide", "CamContact": "contact", "Rolling": "gear", "Rack": "rack"}


def verdict(study: ModelStudy) -> str:
    """Return the verdict on the file's own run and on its driven runs, and the scope of both.

    Whether it is the machine comes first, unless its own run failed.
    """
    if study.distrust:
        return distrust_words(study)
    if study.blocked:
        taken = f" ({study.question.taken})" if study.question.taken else ""
        return f"It is not {study.scene_name} as it stands: {study.blocked}{taken}. Nothing else is judged."
    sentences = [_identity_words(study)]
    if study.own_run is not None:
        sentences.insert(0 if study.own_failed else 1, _own_run_words(study, study.own_run))
    if study.is_machine and not study.model.stops:
        sentences.append(_driven_words(study))
    sentences += _other_forces_words(study)
    if not_judged := list(_not_judged(study)):
        sentences.append(f"Not judged: {'; '.join(not_judged)}.")
    if (begins := study.model.begins) is not None:
        words = begins.words(study.identity.frame.unit)
        sentences.insert(0 if study.begins_open else len(sentences), words)
    if about := study.model.about:
        sentences.append(f"{about[0].upper()}{about[1:]}.")
    return " ".join(sentences)


def _other_forces_words(study: ModelStudy) -> Iterator[str]:
    """Yield sentences on forces that are no loop forces, in the driven and the own run."""
    driven = () if study.driven_run is None else study.driven_run.acting
    named, engine = {one.title for one in driven}, f"MuJoCo {study.model.engine_version}"
    yield from acting_sentences(driven, engine)
    if study.own_run is not None:
        alone = [one for one in study.own_run.acting if one.title not in named]
        yield from acting_sentences(alone, engine, "run as the file has it")


def _identity_words(study: ModelStudy) -> str:
    """Say whether the model is the machine that was named, and whether its limits stop it."""
    if not study.is_machine:
        return f"It is not {study.scene_name} as it stands: {_mismatch_words(study)}."
    if study.model.stops:
        return f"It is {study.scene_name}, but limits keep it from its turn: {'; '.join(study.model.stops)}."
    return f"It is {study.scene_name}."


def _driven_words(study: ModelStudy) -> str:
    """Say in a sentence whether the model's own settings suffice when conrod drives it."""
    own = study.driven_run
    if own is None or own.outcome is not Outcome.COMPLETED:
        how = "did not run" if own is None else f"ended as {own.outcome.slug}: {own.reason}"
        return f"Driven by conrod, with its own settings it {how}."
    return f"Driven by conrod, its own settings are {_judged_words(study, own)}."


def _judged_words(study: ModelStudy, run: JudgedRun) -> str:
    """Say whether a run is within tolerance: 'out of tolerance: position 7.4e-4 > 1.0e-4'."""
    if over := _exceeded_words(study, run):
        return f"out of tolerance: {over}"
    return "within tolerance" if study.tolerance else "measured, not judged"


def _exceeded_words(study: ModelStudy, run: JudgedRun) -> str:
    """List a run's quantities out of tolerance: 'position 7.4e-4 (0.16 mm) > 1.0e-4 (0.021 mm)'."""
    scales = {name: scale for name in study.limits if (scale := study.judged_scale(run, name)) is not None}
    return ", ".join(exceeded_words(study.exceeded_limits(run), scales=scales))


def _own_run_words(study: ModelStudy, run: JudgedRun) -> str:
    """Return the verdict on the file's own run: 'Run as the file has it, ..'."""
    begin, crank = f"Run as the file has it, from {study.model.start},", study.crank
    if crank is None:
        return f"{begin} it ended as {run.outcome.slug}: {run.reason}."
    speed, quiet = f"{_rpm_text(study.scene.speed)} rpm of the scene", _missing_drive(study)
    # A speed below a millionth of the scene's speed is zero.
    seen = [study.scene.speed * round(one / study.scene.speed, 6) for one in (crank.mean, crank.least, crank.most)]
    mean, least, most = map(_rpm_text, seen)
    steady = mean == least == most
    did = f"it turned at {mean} rpm" if steady else f"it turned at {mean} rpm on average, {least} to {most} rpm"
    if not study.has_start:
        still = "does not turn by itself" if crank.is_still else "is moved by its weight alone"
        return f"Its own run is not judged: nothing drives it, from {study.model.start} with {quiet}: it {still}."
    if crank.is_still:
        did = f"its crank stands still, not at the {speed}{f', with {quiet}' if quiet else ''}"
        if study.model.from_keyframe and not study.model.moves and not study.model.controls:
            did += " (a keyframe is a start: give it rates, or take --keyframe qpos0)"
    elif crank.mean * study.scene.speed < 0.0:
        did = f"its crank turns backwards, not at the {speed}: {did}"
    elif study.strays:
        off = abs(crank.mean / study.scene.speed - 1.0)
        allowed = f"by {quantity(100.0 * off, 2)} % on average, allowed {quantity(100.0 * study.speed_tolerance, 2)} %"
        did = f"its crank strays from the {speed} ({allowed}){f', with {quiet}' if quiet else ''}: {did}"
    else:
        did = f"its crank keeps to the {speed}{'' if steady else f': {did}'}"
    if (rates := study.model.rates) is not None:
        found, asked = unequal_quantities(rates.found, rates.asked)
        did += f"; the rates of its start open its loops: {rates.joint} at {found}, they ask for {asked} {rates.unit}"
    if run.errors is None:
        return f"{begin} {did}: OUT OF TOLERANCE."
    if study.strays or study.rates_off or study.exceeded_limits(run):
        over = _exceeded_words(study, run)
        return f"{begin} {did}: OUT OF TOLERANCE{f' ({over})' if over else ''}."
    return f"{begin} {did}; {_judged_words(study, run)}."


def _missing_drive(study: ModelStudy) -> str:
    """Name the missing drive of the file's crank; empty if a control drives it."""
    if any(study.model.controls.values()):
        return ""
    actuators = "all controls at 0 (--ctrl NAME=VALUE)" if study.model.controls else "no actuator"
    return actuators if study.model.moves else f"no rates and {actuators}"


def _not_judged(study: ModelStudy) -> Iterator[str]:
    """Yield the quantities that the verdict does not cover, in words."""
    observed = [point.name for point in study.scene.mechanism().observed]
    if missing := [name for name in observed if name not in study.identity.off_by]:
        yield f"{', '.join(missing)} (not given)"
    if study.points and set(study.points) <= set(study.model.rigid):
        are = "is" if len(study.points) == 1 else "are"
        yield f"what moves by its loops: {', '.join(study.points)} {are} rigid with the crank"
    if study.tolerance and (left := [name for name in QUANTITIES if name not in study.tolerance]):
        yield " and ".join(left)
    yield "forces, masses, damping and gravity"


def _rpm_text(speed: float) -> str:
    return in_shown_unit(speed, "rad/s", 5)[0]


def _mismatch_words(study: ModelStudy) -> str:
    identity = study.identity
    branch = ["it is on the other assembly branch, or to be seen from the other side (--plane)"]
    branch = branch if identity.other_branch else []
    if identity.explanations:
        every = identity.explanations[:MAX_EXPLANATIONS]
        return " and ".join([*branch, " or ".join(map(explanation_words, every))])
    if branch and identity.left <= identity.floor:
        return branch[0]
    off = f"its points are off by up to {with_mm(identity.off_by, study.scene.lengths, ' of their travel')}"
    joints = f"it has {_joint_counts(study)}, the machine {_machine_joints(study.scene)}"
    return "; ".join([*branch, off, f"no lengths explain it: {joints}"])


def findings(study: ModelStudy) -> dict[str, list[str]]:
    """Return sentences on frame, wiring, paths and settings of the model, by subject."""
    unknown = ["not known: it cannot turn as the machine does"] if study.blocked else []
    return {
        "frame": unknown or list(_frame_lines(study)),
        "wiring": list(_wiring_lines(study)),
        "paths (kinematic mode)": unknown or list(_path_lines(study)),
        "its own settings": [study.model.settings],
    }


# -- frame and wiring ------------------------------------------------------------------------------------------------


def _frame_lines(study: ModelStudy) -> Iterator[str]:
    """Yield the model's frame, given or worked out, in sentences."""
    there = study.identity.frame
    if study.question.taken:
        yield study.question.taken
    yield (
        f"plane {there.view.name}, turned by "
        f"{_degrees_text(there.rotation)}, crank zero at {_degrees_text(there.zero)}, unit {_unit_text(study)}"
    )
    anchor, way = " ".join(f"{value:.6g}" for value in there.anchor), "with" if there.sense > 0 else "against"
    yield f"the crank's axis is at ({anchor}) {there.unit_name}; the crank angle grows {way} the hinge's coordinate"


def _unit_text(study: ModelStudy) -> str:
    given = study.question.unit
    name = next((name for name, size in LENGTH_UNITS.items() if size == given), "")
    return study.identity.frame.unit_name if given == 1.0 else f"{name}, converted to m"


def _degrees_text(angle: float) -> str:
    return f"{quantity(round(math.degrees(angle), 6), 9)} deg"


def _wiring_lines(study: ModelStudy) -> Iterator[str]:
    """Yield joints, closures and mobility of the model, in sentences."""
    has, contact = study.model, study.model.touching
    yield f"{_joint_counts(study)}; the machine has {_machine_joints(study.scene)}"
    yield (
        f"mobility {has.coordinates - has.rank - (1 if contact else 0)}: {has.coordinates} degrees of freedom, of "
        f"which closures take {has.rank}{f' and the contact of {contact[0]} and {contact[1]} 1' if contact else ''}"
    )


def _joint_counts(study: ModelStudy) -> str:
    """Count the joints and closures of the model, in words."""
    has = study.model
    named = {kind if kind in ("connect", "weld") else f"equality of {kind}s": n for kind, n in has.closures.items()}
    return _counts_text({**has.joints, **named})


def _machine_joints(scene: Scene) -> str:
    return _counts_text(Counter(JOINT_NAMES[type(joint).__name__] for joint in scene.mechanism().joints))


def _counts_text(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{count} {name}{'' if count == 1 else 's'}" for name, count in counts.items())


# -- paths and lengths -----------------------------------------------------------------------------------------------


def _path_lines(study: ModelStudy) -> Iterator[str]:
    """Yield how far the points' paths are from the exact ones, and which points were not given."""
    identity, lengths = study.identity, study.scene.lengths
    off = ", ".join(f"{name} {with_mm({name: size}, lengths, OF_ITS_TRAVEL)}" for name, size in identity.off_by.items())
    yield f"largest distance from the exact path{' of the other branch' if identity.other_branch else ''}: {off}"
    if missing := [p.name for p in study.scene.mechanism().observed if p.name not in identity.off_by]:
        yield f"not given, so not judged: {', '.join(missing)}"


def explanation_words(found: Explanation) -> str:
    """Name the lengths and places that are off, with their sizes."""
    places = (f"{p.point} is {MM * p.away:.4g} mm from where it should be on its link" for p in found.misplaced)
    return " and ".join([*map(length_words, found.lengths), *places])


def length_words(one: FoundLength) -> str:
    """Say how far a length is off: 'rod is 0.01 % too long: 325.0325 mm instead of 325 mm'."""
    excess = one.excess
    if excess is None:
        return f"{one.name} is {MM * one.found:.6g} mm instead of 0 mm"
    if one.name == ALL_LENGTHS:
        return f"all lengths are {one.found:.7g} times those expected"
    share = f"{round_to_digits(100.0 * abs(excess), 2):g} % too {'long' if excess > 0.0 else 'short'}"
    digits = max(6, 2 - math.floor(math.log10(abs(excess) or 1.0)) + 1)
    return f"{one.name} is {share}: {MM * one.found:.{min(digits, 15)}g} mm instead of {MM * one.expected:.6g} mm"


# -- runs ------------------------------------------------------------------------------------------------------------


def runs_table(study: ModelStudy) -> Table:
    """Return a row for each run: its largest errors and its verdict."""
    own_runs = [] if study.own_run is None else [study.own_run]
    rows = [
        (
            *(
                run.label,
                quantity(run.steps_per_revolution, 5),
                measured_text(run.worst("position")),
                _position_in_mm(study, run),
            ),
            *(*(measured_text(run.worst(q)) for q in QUANTITIES[1:]), words),
        )
        for run in (*own_runs, *study.runs.values())
        if (words := _run_verdict(study, run))
    ]
    caption = "its own run, and runs with conrod's drive: largest error, normalised by L, ω L, ω² L"
    return table(("settings", *RIGHT_COLUMNS, "verdict"), rows, RIGHT_COLUMNS, caption)


def qualification_table(study: ModelStudy) -> Table:
    """Return a row for each planted defect: whether the check notices it; empty if none was planted."""
    return noticed_table(study.scene_name, {} if study.qualified is None else {"this check": study.qualified})


def _position_in_mm(study: ModelStudy, run: JudgedRun) -> str:
    errors = {point: sizes["position"].max for point, sizes in (run.errors or {}).items()}
    return in_mm(errors, study.scene.lengths)


def _run_verdict(study: ModelStudy, run: JudgedRun) -> str:
    if run.outcome is not Outcome.COMPLETED:
        return f"{run.outcome.slug}: {run.reason}"
    if run.errors is None:
        return "STANDS STILL" if study.strays else "does not turn"
    if run is study.own_run and study.strays:
        return "STANDS STILL" if study.crank and study.crank.is_still else "STRAYS"
    if not any(run is one for one in study.judged):
        return "measured"
    if study.exceeded_limits(run) or (run is study.own_run and study.rates_off):
        return "OUT OF TOLERANCE"
    return "within tolerance" if study.tolerance else "measured"


def drive_lines(study: ModelStudy) -> Iterator[str]:
    """Yield sentences on the crank's drive and the reference of the runs."""
    own, identity = study.driven_run, study.identity
    if own is None:
        far = "it is too far off the machine for its runs to say anything"
        yield f"not driven: {'it cannot turn as the machine does' if study.blocked else far}"
        return
    yield "the crank is driven by a flywheel in the compiled model, whose place and rate are written at every step"
    yield from (f"{preset}: {reason}" for preset, reason in study.refused.items())
    if left_out := [name for name in identity.off_by if name not in study.points]:
        yield f"compared without {', '.join(left_out)}, which is not where it should be"
    if identity.explanations:
        yield "compared with the exact motion of the lengths that were found"


# -- the report ------------------------------------------------------------------------------------------------------


def _summary(study: ModelStudy) -> dict[str, Any]:
    return {"is_machine": study.is_machine, "passed": study.passed, "verdict": verdict(study)}


def results_to_print(studies: Sequence[ModelStudy]) -> Iterator[PrintedPart]:
    """Yield the verdict, runs, frame, wiring and paths of each model."""
    for study in studies:
        yield verdict_line(f"{study.file}: {verdict(study)}", study.passed)
        yield runs_table(study)
        yield qualification_table(study)
        for subject, lines in {"runs": drive_lines(study), **findings(study)}.items():
            yield from indented_under(subject, lines)


def _live_html(part: Part[ModelStudy], anchor: str) -> str:
    """Return the HTML of the drawing that moves, under an anchor of the page; empty if nothing is drawn."""
    from conrod.report.html.moving_links import links_html

    return links_html(part.findings.drawn, anchor, Path(part.findings.file).name)


MODEL_REPORT = Kind(
    name="model",
    findings=ModelStudy,
    title=lambda study: f"{Path(study.file).name}: is it {study.scene_name}?",
    summary=_summary,
    printed=results_to_print,
    verdict=verdict,
    one_part=True,
    live_html=_live_html,
)
