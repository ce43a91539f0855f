"""The report on an inspection: the answer in a line, six sections, and the command to type next."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any
from urllib.parse import quote

from conrod.comparison.other_forces import CONTACT, LIMIT, acting_sentences
from conrod.comparison.trajectory import Outcome
from conrod.errors import list_names
from conrod.mjcf.loop_results import LoopRun
from conrod.mjcf.request import LENGTH_UNITS
from conrod.models.inspection.actuator_results import SERVOS, SPEEDS, ActuatorResult
from conrod.models.inspection.results import UNEXPLAINED, Closing, Inspection, Loading, PoseOpening
from conrod.models.loops.words import in_mm, lines_to_paste, settings_words
from conrod.report.kind import Index, Kind, Part
from conrod.report.numbers import quantity
from conrod.report.table import Table, Verbatim, table
from conrod.report.terminal import PrintedPart, verdict_line

MAX_POSE_NUMBERS = 20  # coordinates of a pose in a sentence
SAID_BEFORE = ("open-start", "parts-apart", "redundant-closure")  # rules of lint that other sections say
SOFT_CLOSURE = "soft-closure"  # a rule of lint, which allows 1e-4 of the size (`MAX_BEARING_PLAY`)
START_MOVED = "the motion starts from"
OBSTACLES = (LIMIT, CONTACT)  # kinds of forces that the exact motion lacks
HOLD = "hold"  # law of a joint that stays where it stands
INACTIVE = "inactive ("  # in words on closures that do not act
MAX_ALARMS = 2  # of actuators in the first sentences
SWING_SIZES = {"rad": (math.radians(20.0), "deg"), "m": (0.02, "mm")}  # of a first law, by a servo's unit
SPEED_SHARE = 0.8  # of the speed that was tried, which its control can command
MAX_NAMED = 4  # closures, poses or parts named in a sentence


def finding(study: Inspection) -> str:
    """Summarise an inspection: whether the model loads, closes and moves, and its faults."""
    closing = study.closing
    reached = _reached_words(study)
    if not closing.start.gaps:
        said = f"It loads{', and' if reached else ''}{reached}."
    else:
        said = f"It loads and closes{', and' if reached else ''}{reached}."
    if not closing.passed:
        start = closing.start
        what = closing.remarks[-1] if closing.apart else f"{start.worst} is open by {in_mm(start.largest)}"
        said = f"It loads but does not close: {what}{'' if closing.apart else f' in {start.pose}'}."
    sentences = [said]
    if likely := study.loading.likely_unit:
        sentences.append(f"Its sizes are those of a model in {likely}: --unit {likely} says so.")
    sentences += [f"{one[0].upper()}{one[1:]}." for one in study.moving.alarms[:MAX_ALARMS]]
    if more := study.moving.alarms[MAX_ALARMS:]:
        sentences.append(f"And {_count_text(len(more), 'more alarm')} of its actuators.")
    nothing_said = not study.moving.passed and not study.moving.alarms
    if not study.loading.joints or study.moving.is_stuck_closed or nothing_said:
        sentences.append("Nothing of it can move.")
    if closing.passed and study.motion is not None and study.motion.driven_run.outcome is not Outcome.COMPLETED:
        sentences.append(f"Driven by {next(iter(study.drives))} it {_end_words(study.motion.driven_run)}.")
    elif closing.passed and study.motion is not None and study.motion.driven_run.errors:
        off = in_mm(study.motion.driven_run.errors["position"])
        met = list_names((one.title for one in study.motion.driven_run.acting if one.kind in OBSTACLES), MAX_NAMED)
        way = f", with {met} in its way" if met else ""
        sentences.append(
            f"Driven by {next(iter(study.drives))} it is {off} off its exact motion at its own settings{way}."
        )
    if sentences == ["It loads."]:
        sentences += _unjudged_sentences(study)
    if any(one.rule == "nothing-moves" for one in study.findings):
        sentences.append("Nothing moves in its own run.")
    if errors := [one.rule for one in study.errors if one.rule not in SAID_BEFORE]:
        sentences.append(f"Lint has {_count_text(len(errors), 'error')}: {list_names(errors, MAX_NAMED)}.")
    return " ".join(sentences)


def _unjudged_sentences(study: Inspection) -> list[str]:
    """Say which parts followed a law, or why no motion is judged, of a model without other findings."""
    if followed := study.moving.followed:
        return [f"With {one.words}." for one in followed[:MAX_ALARMS]]
    if pushed := [one.name for one in study.moving.actuators if one.acceleration is not None]:
        are = f"{list_names(pushed, MAX_NAMED)} {'is a force' if len(pushed) == 1 else 'are forces'}"
        return [f"It has no closed loop, and {are}: no motion of it is judged."]
    inactive = next((one for one in study.closing.remarks if INACTIVE in one), "")
    loop = f"{inactive[0].upper()}{inactive[1:]}: it has no other" if inactive else "It has no"
    return [f"{loop} closed loop and no actuator that was tried: no motion of it is judged."]


def _reached_words(study: Inspection) -> str:
    """Say that all actuators reach their commands; empty if one fails, or none was commanded."""
    tried = [one for one in study.moving.actuators if one.responses]
    if not tried or study.moving.alarms:
        return ""
    many = f" its {len(tried)} actuators reach what they are told"
    return f" its actuator {tried[0].name} reaches what it is told" if len(tried) == 1 else many


# -- the six sections --------------------------------------------------------------------------------------------------


def sections(study: Inspection) -> Iterator[tuple[str, list[str]]]:
    """Yield the question and the lines of each section."""
    yield "1 does it load?", list(_loading_lines(study.loading))
    yield "2 does it close?", list(_closing_lines(study.closing))
    yield "3 what moves it?", list(study.moving.lines)
    yield "4 how exact?", list(_exact_lines(study))
    yield "5 what to set?", list(_setting_lines(study))
    yield "6 what else?", list(_lint_lines(study))


def _loading_lines(found: Loading) -> Iterator[str]:
    """Yield the answer to whether the model loads: its parts, size and mass, and missing files."""
    parts = [
        _count_text(found.bodies, "body", "bodies"), _count_text(found.joints, "joint"),
        _count_text(found.closures, "closure"), _count_text(found.actuators, "actuator"),
    ]  # fmt: skip
    size = f"{quantity(found.across, 3)} m across, {quantity(found.mass, 3)} kg"
    yield f"yes: {', '.join(parts)}; {size}"
    yield from (*found.left_out, *found.remarks)


def _closing_lines(found: Closing) -> Iterator[str]:
    """Yield the answer to whether the model's loops close: its poses, and the open closures of each."""
    if not found.start.gaps:
        yield "it has no closed loop that acts" if found.remarks else "it has no closed loop"
    for pose in found.poses if found.start.gaps else ():
        named = found.is_named(pose)
        if named or pose is found.start:
            yield _pose_line(pose, named)
    if len(found.poses) > 1 and not any(map(found.is_named, found.poses[1:])) and found.start.gaps:
        yield f"closed in {list_names((pose.pose for pose in found.poses[1:]), MAX_NAMED)} too"
    yield from _range_lines(found.start)
    yield from found.remarks


def _pose_line(pose: PoseOpening, named: bool) -> str:
    gap = f"{pose.worst} is open by {in_mm(pose.largest)} in {pose.pose}"
    more = f" ({_count_text(len(pose.gaps) - 1, 'other closure')} by no more)" if len(pose.gaps) > 1 else ""
    if not named:
        return f"yes: {gap}{more}"
    if not pose.closed:
        return f"{gap}{more}: no pose near it closes it: look at lengths and places of the closures"
    return f"{gap}{more}; the nearest closed pose is {_pose_text(pose.closed)}"


def _pose_text(pose: str) -> str:
    """Return a pose as an attribute of MJCF, or where a pose too long for a sentence is printed."""
    return f'qpos="{pose}"' if len(pose.split()) <= MAX_POSE_NUMBERS else "below"


def _range_lines(pose: PoseOpening) -> Iterator[str]:
    """Yield which joints are outside their ranges in a pose, and the nearest closed pose inside them."""
    if pose.outside:
        inside = f": the nearest closed pose inside is {_pose_text(pose.inside)}" if pose.inside else ""
        yield f"{pose.outside}{inside}; give --keyframe to start elsewhere"
    if pose.singular:
        yield f"{pose.pose} is singular (folded, or a change point): its loops allow more motion there than beside it"


def _exact_lines(study: Inspection) -> Iterator[str]:
    """Yield how far the model's driven runs are from its exact motion, or why that is not judged."""
    motion = study.motion
    if motion is None:
        yield f"not judged: {study.not_judged}"
        return
    driven = [f"{joint}={law}" for joint, law in study.drives.items() if law != HOLD]
    held = [joint for joint, law in study.drives.items() if law == HOLD]
    drives = " and ".join(driven) + (f" (held: {list_names(held, MAX_NAMED)})" if held else "")
    own = motion.driven_run
    if own.outcome is not Outcome.COMPLETED:
        yield f"driven by {drives} it {_end_words(own)}"
    else:
        loops = f", its loops open by up to {in_mm(own.gap or 0.0)}"
        yield f"driven by {drives}, {own.worst} is off by {in_mm(own.errors['position'])} as it is{loops}"
    obstacles = [one for one in own.acting if one.kind in OBSTACLES]
    yield from (words[0].lower() + words[1:].removesuffix(".") for words in acting_sentences(obstacles))
    others = [f"{run.label} {in_mm(run.errors['position'])}" for run in motion.runs[1:] if run.errors]
    if others:
        yield f"at the same step: {', '.join(others)}"
    # Which joints are outside their ranges is said before.
    folded = "its start is folded: " if ", and is folded:" in motion.moved_start else ""
    moved = folded + "".join(motion.moved_start.partition(START_MOVED)[1:])
    yield from filter(None, (moved, study.not_judged))


def _end_words(run: LoopRun) -> str:
    """Say how a driven run ended that did not complete."""
    return f"ends as {run.outcome.slug}: {run.reason}"


def _setting_lines(study: Inspection) -> Iterator[str]:
    """Yield whether the model's settings are within tolerance, and the cheapest that are."""
    motion = study.motion
    if motion is None or motion.search is None:
        yield "nothing was judged"
        return
    if motion.driven_run.is_within(motion.search.allowed):
        within = f"{in_mm(motion.search.allowed['position'])}, a thousandth of its range of motion"
        soft = any(one.rule == SOFT_CLOSURE for one in study.findings)
        less = "; 6 asks more of closures, a bearing's play, which is a ten-thousandth of its size" if soft else ""
        yield f"nothing: its own settings are within {within}{less}"
        if motion.search.best is None:  # cut short: its own hold, and no other that was tried
            return
    yield settings_words(motion)


def poses_to_paste(study: Inspection) -> Iterator[tuple[str, str]]:
    """Yield a title and the line to paste of each nearest pose with too many numbers for a sentence."""
    start = study.closing.start
    for name, pose, what in (("closed", start.closed, ""), ("inside", start.inside, " inside all ranges")):
        if len(pose.split()) > MAX_POSE_NUMBERS:
            yield f"the nearest closed pose{what}, to paste before </mujoco>", _keyframe(name, pose)


def parts_to_paste(study: Inspection) -> Iterator[tuple[str, str]]:
    """Yield a title and the lines of each part to paste: poses, then settings."""
    yield from poses_to_paste(study)
    yield from settings_to_paste(study)


def settings_to_paste(study: Inspection) -> Iterator[tuple[str, str]]:
    """Yield a title and the lines of each group to paste, if the model's settings miss the tolerance."""
    motion = study.motion
    if motion is not None and motion.search is not None and not motion.driven_run.is_within(motion.search.allowed):
        yield from lines_to_paste(motion)


def _lint_lines(study: Inspection) -> Iterator[str]:
    told = [one for one in study.findings if one.rule not in SAID_BEFORE]
    if not told and not study.lint_notes:
        yield "nothing"
    for one in told:
        fix = "lint sees no closure under load" if one.rule == "nothing-moves" and study.motion else one.fix
        play = ", more than a bearing's play, a ten-thousandth of its size" if one.rule == SOFT_CLOSURE else ""
        yield f"{one.severity.value} {one.rule}: {one.what}{play}: {fix}"
    yield from study.lint_notes


# -- the command to type next ------------------------------------------------------------------------------------------


def next_step(study: Inspection) -> str:
    """Return what to do next, with the command to type."""
    if likely := study.loading.likely_unit:  # no size is right before that
        size_is_right = replace(study, loading=replace(study.loading, likely_unit=""))
        return f"if it is in {likely}: {_command(study, '--unit', likely)}; otherwise: {next_step(size_is_right)}"
    again = _command(study)
    if said := _mending_step(study, again):
        return said
    if _can_be_pasted(study):
        return f"paste the lines above before </mujoco>, then {again}"
    if any(one.rule == SOFT_CLOSURE for one in study.errors) or any(settings_to_paste(study)):
        return shlex.join(["conrod", "harden", study.file, *_unit_words(study)])
    if study.motion is not None and study.motion.search is not None:
        drives = [word for joint, law in study.drives.items() for word in ("--drive", f"{joint}={law}")]
        allowed = float(f"{1e3 * study.motion.search.allowed['position']:.1g}")
        return _command(study, *drives, "--tolerance", f"position={allowed:.15g}mm")
    return _first_drive(study)


def _mending_step(study: Inspection, again: str) -> str:
    """What must be mended first: parts that do not meet, a blocked loop, a start, no joint; empty if nothing.

    Args:
        again: the command that inspects the model again.
    """
    closing, start = study.closing, study.closing.start
    if closing.apart or (not closing.passed and not start.closed):
        what = "connect sites where the parts meet" if closing.apart else f"mend lengths and places of {start.worst}"
        return f"{what}, then {again}"
    if study.moving.is_stuck_closed:
        shown = (
            f": one of {list_names(start.gaps, MAX_NAMED)} is too many"
            if study.not_judged == UNEXPLAINED
            else ", as 4 says"
        )
        return f"mend what leaves it no freedom{shown}, then {again}"
    for name, pose in (("closed", "" if closing.passed else start.closed), ("inside", start.inside)):
        if pose:
            return f"{_keyframe_words(name, pose)}, then {_command(study, '--keyframe', name)}"
    return "" if study.loading.joints else f"give it a joint, then {again}"


def _can_be_pasted(study: Inspection) -> bool:
    """True if the settings that are printed can be written into the file as a whole."""
    motion = study.motion
    lines = motion is not None and motion.paste and any(settings_to_paste(study))
    return bool(lines and motion is not None and motion.search is not None and not motion.search.after_compiling)


def _first_drive(study: Inspection) -> str:
    """The command that drives a model whose motion is not judged yet; it has a loop or an actuator that can follow."""
    first = next((one for one in study.moving.actuators if one.kind in (*SERVOS, *SPEEDS)), None)
    if first is None:
        return f"conrod invariances {shlex.quote(study.file)}"
    return _command(study, "--drive", f"{first.name}={_suggested_law(first)}")


def _suggested_law(actuator: ActuatorResult) -> str:
    """A law to suggest for an actuator: a sine about its start, or a move if a servo's range is too small."""
    ends, (size, unit) = [one.target for one in actuator.responses], SWING_SIZES[actuator.unit]
    begin = actuator.responses[0].begin if ends else 0.0
    if actuator.kind in SPEEDS and ends and 2.0 * math.pi * size > (fastest := SPEED_SHARE * abs(ends[-1])):
        return f"sine:{20.0 / size * fastest / (2.0 * math.pi):.2g}{unit},1Hz"  # its rate is 2 pi times as much
    if actuator.kind not in SERVOS or len(ends) < 2 or min(abs(end - begin) for end in ends) >= size:
        return f"sine:20{unit},1Hz"
    scale = 20.0 / size
    return f"move:{scale * begin:.3g}{unit},{scale * 0.5 * (begin + ends[0]):.3g}{unit},1s"


def _command(study: Inspection, *words: str) -> str:
    """The command that inspects the same model, with further arguments."""
    asked, given = study.question, _unit_words(study)
    given += ["--keyframe", asked.keyframe] if asked.keyframe is not None and "--keyframe" not in words else []
    return shlex.join(["conrod", "check", study.file, *given, *words])


def _unit_words(study: Inspection) -> list[str]:
    """The option of a unit other than the metre."""
    unit = study.question.unit
    name = next(name for name, size in LENGTH_UNITS.items() if size == unit)
    return [] if unit == 1.0 else ["--unit", name]


def _keyframe_words(name: str, pose: str) -> str:
    if len(pose.split()) > MAX_POSE_NUMBERS:
        return f"paste keyframe {name} above before </mujoco>"
    return f"write {_keyframe(name, pose)}"


def _keyframe(name: str, pose: str) -> str:
    return f'<keyframe><key name="{name}" qpos="{pose}"/></keyframe>'


# -- printing ----------------------------------------------------------------------------------------------------------


def results_to_print(studies: Sequence[Inspection]) -> Iterator[PrintedPart]:
    """Yield the summary of each model, its sections, and the next command."""
    for study in studies:
        yield verdict_line(f"{study.file}: {finding(study)}", study.passed)
        yield ""
        for question, lines in sections(study):
            yield from (question, *(f"  {line}" for line in lines))
        for what, text in parts_to_paste(study):
            yield from ("", f"{what}:", Verbatim(text))
        yield from ("", f"next: {next_step(study)}", "")


def _count_text(count: int, one: str, many: str = "") -> str:
    """Return a count with its noun: '1 joint', '3 joints', 'no joints'."""
    return f"{count or 'no'} {one if count == 1 else many or f'{one}s'}"


def _summary(study: Inspection) -> dict[str, Any]:
    return {"passed": study.passed, "finding": finding(study), "next": next_step(study)}


def index_table(index: Index[Inspection]) -> Table:
    """Return a row for each model, with the summary of its inspection."""
    rows = [
        (f"[{entry['title']}]({quote(entry['page'])})", entry["summary"]["finding"]) for entry in index.entries.values()
    ]
    return table(("model", "what was found"), rows)


def headline(entries: Mapping[str, Mapping[str, Any]]) -> str:
    """Say how many of the inspected models failed."""
    summaries = [entry["summary"] for entry in entries.values()]
    failed = sum(one["passed"] is False for one in summaries)
    return f"Something stands in the way in {failed} of {len(summaries)} models."


def _live_html(part: Part[Inspection], anchor: str) -> str:
    """Return the HTML of the drawing that moves, under an anchor of the page; empty if nothing is drawn."""
    from conrod.report.html.moving_links import links_html

    return links_html(part.findings.picture, anchor, part.findings.name)


INSPECTION_REPORT = Kind(
    name="inspection",
    findings=Inspection,
    title=lambda study: study.name,
    summary=_summary,
    printed=results_to_print,
    verdict=finding,
    headline=headline,
    results="inspection.json",
    index_file="inspection.md",
    suffix="-inspection",
    live_html=_live_html,
)
