"""The report on a model's closed loops: what moves, the errors of its engine, and settings that would suffice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any
from urllib.parse import quote

from conrod.comparison.other_forces import acting_sentences, merge_forces
from conrod.comparison.trajectory import Outcome
from conrod.mjcf.differences import MachineComparison
from conrod.mjcf.loop_results import (
    LABELS,
    LOOP_UNITS,
    LOOPS,
    OWN_SETTINGS,
    LawComparison,
    LoopRun,
    LoopStudy,
    loop_limits,
)
from conrod.models.loops.words import PAGE_UNITS, in_mm, lines_to_paste, settings_words, shipped_words, with_share
from conrod.report.kind import Index, Kind, Part
from conrod.report.numbers import in_shown_unit, measured_text, order, quantity
from conrod.report.table import VERDICT, ColouredCell, Table, Verbatim, table
from conrod.report.terminal import PrintedPart, indented_under, verdict_line

RIGHT_COLUMNS = (
    "step [ms]",
    "position [mm]",
    "velocity [m/s]",
    "acceleration [m/s²]",
    "loops open [mm]",
    "order",
    "cost",
)
MAX_NAMED_DIFFERENCES = 4  # differences, points or bodies named in a sentence
MIN_CONTRADICTION = 1e-9  # of the travel; less is rounding


def finding(study: LoopStudy) -> str:
    """Return the verdict on the file's own run and on its driven runs, and the scope of both.

    If it is another machine than the scene, the verdict says so first, unless its own run failed.
    """
    shipped, own = study.shipped, study.driven_run
    said = [_own_run_words(study), _driven_run_words(study)]
    if not study.shipped_failed and not (study.is_machine and study.agrees):
        said.reverse()
    said += _other_forces_words(study)
    said += [f"{words[0].upper()}{words[1:]}." for words in (study.moved_start, study.about) if words]
    if not_judged := list(_not_judged(study)):
        said.append(f"Not judged: {'; '.join(not_judged)}.")
    if study.begins is not None:
        said.insert(0 if study.begins_open else len(said), study.begins.words())
    if study.is_machine and study.compared is not None and (words := _difference_words(study.compared)):
        said.append(f"Its points are where those of {study.compared.machine} are, though {words}.")
    if study.compared is not None and (loads := study.compared.loads):
        said.append(f"Loads are not judged, and differ: {_first_differences(loads)}.")
    if words := settings_words(study):
        said.append(words)
    if own.outcome is Outcome.COMPLETED and own.label == OWN_SETTINGS:
        best = min(
            (run for run in study.runs if run.errors), key=lambda run: max(run.errors["position"], run.gap or 0.0)
        )
        if best is not own:
            said.append(f"At the same step `{best.label}` is within {in_mm(best.errors['position'])}.")
            if (run := study.presets.get(best.label)) is not None and run.failed and not shipped.failed:
                said.append(f"But with it and its own actuators the file {shipped_words(run)}.")
    return " ".join(said)


def _other_forces_words(study: LoopStudy) -> Iterator[str]:
    """Yield sentences on forces that are no loop forces, in the driven and the own run."""
    driven, engine = study.driven_run.acting, f"MuJoCo {study.engine_version}"
    named = {one.title for one in driven}
    yield from acting_sentences(driven, engine)
    alone = [one for one in study.shipped.acting if one.title not in named]
    yield from acting_sentences(alone, engine, "run as the file has it")


def _own_run_words(study: LoopStudy) -> str:
    """Say in a sentence whether the file's own run is within tolerance."""
    shipped, asked = study.shipped, study.question.tolerance
    did = f"Run as the file has it, from {shipped.start}, it {shipped_words(shipped)}"
    if shipped.failed:
        return f"{did}."
    if not shipped.driven:
        return f"{did}: not judged, nothing drives it (no control and no rate at its start)."
    did += "".join(f", {words}" for words in _law_words(shipped.laws))
    if shipped.exceeds(asked):
        return f"{did}: OUT OF TOLERANCE (allowed {with_share(study, LOOPS, loop_limits(asked)[LOOPS])})."
    if shipped.laws.differs:
        return f"{did}: OUT OF TOLERANCE."
    return f"{did}: {'within tolerance' if LOOPS in loop_limits(asked) else 'measured, not judged'}."


def _law_words(laws: LawComparison) -> Iterator[str]:
    """Say how speeds of the file's own run differ from the laws, and whether it is on another branch."""
    for one in laws.strayed:
        law, mean, least, most = (
            in_shown_unit(one.law * round(speed / one.law, 6), "rad/s", 5)[0]
            for speed in (one.law, one.own.mean, one.own.least, one.own.most)
        )
        span = "" if least == most else f" on average, {least} to {most} rpm"
        if one.own.is_still:
            did = "stands still"
        elif one.own.mean * one.law < 0.0:
            did = f"turns backwards, at {mean} rpm{span}"
        else:
            did = f"turns at {mean} rpm{span}"
        yield f"{one.joint} {did}, not at the {law} rpm of its law"
    if laws.other_branch:
        yield "it is on another assembly branch than the motion of the laws"


def _not_judged(study: LoopStudy) -> Iterator[str]:
    """Yield the quantities that the verdict does not cover, in words."""
    asked, idle = study.question.tolerance, study.mobility.idle
    if study.judges_loops_alone:
        more = ", .." if len(study.points) > MAX_NAMED_DIFFERENCES else ""
        named = f"{', '.join(study.points[:MAX_NAMED_DIFFERENCES])}{more}"
        rigid = f"{named} {'is' if len(study.points) == 1 else 'are'} rigid with what is driven"
        instead = f" (--point takes {', '.join(study.moved[:MAX_NAMED_DIFFERENCES])})" if study.moved else ""
        yield f"what moves by the loops: {rigid}{instead}"
    if asked and (left := [name for name in LOOP_UNITS if name not in asked]):
        yield " and ".join(left)
    if others := [one.title for one in merge_forces(one for run in study.runs for one in run.acting) if not one.exact]:
        borne = f"{', '.join(others[:MAX_NAMED_DIFFERENCES])}{', ..' if len(others) > MAX_NAMED_DIFFERENCES else ''}"
        yield f"forces: torques of drives and reactions bear {borne} too, which the exact ones do not have"
    elif asked:
        yield "forces"
    shipped = study.shipped
    compared = [one.joint for one in shipped.laws.speeds]
    left = [name for name in study.question.drives if name not in compared]
    if left and shipped.driven and not shipped.failed:
        yield f"whether its own run moves {', '.join(left[:MAX_NAMED_DIFFERENCES])} by the laws"
    if study.mobility.undetermined:
        yield f"what {', '.join(idle[:MAX_NAMED_DIFFERENCES])} moves, which the drives do not determine"


def _driven_run_words(study: LoopStudy) -> str:
    own = study.driven_run
    if not study.is_machine and (other := study.compared) is not None:
        off = "" if other.off is None else f"; {other.point} is up to {in_mm(other.off)} off"
        if other.off is not None and replace(study, compared=replace(other, other_kinds=False)).is_machine:
            off = ", though its points are where those of the machine are"
        words = _difference_words(other) or "why is not known: no length, axis, anchor or loop differs"
        return f"It is not {other.machine} as it stands: {words}{off}."
    if not study.agrees:
        worst = max(study.kinematic, key=lambda name: study.kinematic[name])
        off = measured_text(study.kinematic[worst])
        return f"MuJoCo does not place it as its exact motion does: {worst} off by {off}."
    if own.outcome is not Outcome.COMPLETED:
        met = f"; {study.remarks[0]}" if study.remarks else ""
        return f"Driven with its own settings it ended as {own.outcome.slug}: {own.reason}{met}."
    off = with_share(study, "position", own.errors["position"])
    gap = f"its loops open by up to {in_mm(own.gap or 0.0)}, and {own.worst} is off its exact place by {off}"
    if not study.question.tolerance:
        return f"Driven with its own settings {gap}: measured, not judged."
    over = [
        f"{'loops open' if name == LOOPS else name} {with_share(study, name, found)}, "
        f"allowed {with_share(study, name, allowed)}"
        for name, (found, allowed) in own.exceeded_limits(study.question.tolerance).items()
    ]
    verdict = f"OUT OF TOLERANCE ({', '.join(over)})" if over else "within tolerance"
    return f"Driven with its own settings {gap}: {verdict}."


def _difference_words(other: MachineComparison) -> str:
    """Name the differences between the model and the machine; empty where none is found."""
    if other.other_branch:
        return "it is assembled on another branch"
    return _first_differences(other.differences)


def _first_differences(differences: Sequence[str]) -> str:
    """List the first differences, and the number of the rest."""
    more = len(differences) - MAX_NAMED_DIFFERENCES
    return "; ".join([*differences[:MAX_NAMED_DIFFERENCES], *([f"{more} more differences"] if more > 0 else [])])


def runs_table(study: LoopStudy) -> Table:
    """Return a row for each run at the model's own step, and for the cheapest sufficient run with twice its step."""
    search = study.search
    others = () if search is None else (search.best, search.coarser)
    runs = [*study.runs, *(run for run in others if run is not None)]
    rows = [
        (run.label, *_error_cells(run), order(run.order), measured_text(run.cost), _run_verdict(study, run))
        for run in runs
    ]
    title = "driven along the exact motion: largest errors"
    return table(("settings", *RIGHT_COLUMNS, VERDICT), rows, RIGHT_COLUMNS, title)


def _error_cells(run: LoopRun) -> tuple[str, ...]:
    errors = [
        measured_text(factor * run.errors[name]) if run.errors else "" for name, (factor, _) in PAGE_UNITS.items()
    ]
    return quantity(1e3 * run.timestep), *errors, "" if run.gap is None else measured_text(1e3 * run.gap)


def _run_verdict(study: LoopStudy, run: LoopRun) -> ColouredCell | str:
    if run.outcome is not Outcome.COMPLETED:
        return ColouredCell(f"{run.outcome.slug}: {run.reason}", "odd")
    if not study.question.tolerance:
        return "measured"
    return (
        ColouredCell("within tolerance", "good")
        if run.is_within(study.question.tolerance)
        else ColouredCell("OUT OF TOLERANCE", "bad")
    )


def mobility_facts(study: LoopStudy) -> Iterator[str]:
    """Yield drives, mobility, redundant equations, idle joints, nearest singular configuration."""
    one, drives = study.mobility, ", ".join(f"`{name}={law}`" for name, law in study.question.drives.items())
    yield f"driven: {drives}; {quantity(study.seconds)} s; points go up to {in_mm(study.travel)} from their start"
    taken = f"{one.rows} equations of its closures take {one.rank}"
    yield f"mobility {one.remaining_dof}: of {one.freedom} degrees of freedom of its joints {taken}"
    if one.redundant:
        yield "redundant equations: " + ", ".join(f"{rows} of {name}" for name, rows in one.redundant.items())
    if one.idle:
        rest = f"; not judged: {', '.join(one.undetermined)}" if one.undetermined else ""
        yield f"idle: {', '.join(one.idle)} can move without its drives{rest}"
    if study.held:
        yield f"held, as no loop contains them: {', '.join(study.held)}"
    least = f"the least singular value is {measured_text(one.margin)} of the largest"
    yield f"nearest to a singular pose at {quantity(one.margin_time)} s: {least}"
    if study.misfit > MIN_CONTRADICTION * study.travel:
        apart = f"they stay open by {in_mm(study.misfit)} at best"
        yield f"its closures contradict each other: {apart}, and the exact motion is no more exact than that"
    yield from study.remarks


def exactness_facts(study: LoopStudy) -> Iterator[str]:
    """Yield the differences of MuJoCo's kinematics, closed form and forces from the exact ones."""
    off = ", ".join(f"{name} {measured_text(size)}" for name, size in study.kinematic.items())
    yield f"kinematic mode: MuJoCo's own kinematics differ from the exact motion by {off}, over the largest of each"
    if study.compared is not None and study.compared.closed_form is not None:
        off = measured_text(study.compared.closed_form)
        yield f"the closed form of {study.compared.machine} differs from its exact motion by {off} of the travel"
    if study.compared is not None and not study.compared.loads:
        yield f"masses, damping and gravity are those of {study.compared.machine}, body by body and joint by joint"
    if study.unmodelled:
        yield f"forces are not compared, for there are others: {', '.join(study.unmodelled)}"
    for run in study.runs:
        if run.drives:
            torques = _force_words("torque of drives", run.drives)
            yield f"{run.label}: {torques}; {_force_words('reactions', run.reactions)}"
    if study.ambiguous:
        shared = f"how {', '.join(study.ambiguous)} share their forces"
        yield f"redundant closures leave open {shared}; what they leave open is not compared"
    for label, shipped in study.presets.items():
        yield f"{label}, with the file's own actuators: it {shipped_words(shipped)}"


def _force_words(what: str, found: Mapping[str, float]) -> str:
    """Say how far forces are off at most, given their relative errors by name."""
    if not found:
        return f"{what}: none that is determined"
    worst = max(found, key=lambda name: found[name])
    return f"{what} off by up to {measured_text(found[worst])} of the largest ({worst})"


def _summary(study: LoopStudy) -> dict[str, Any]:
    cheapest = study.cheapest and f"{study.cheapest.label}, {quantity(1e3 * study.cheapest.timestep)} ms"
    return {
        "passed": study.passed,
        "finding": finding(study),
        "mobility": study.mobility.remaining_dof,
        "redundant": sum(study.mobility.redundant.values()),
        "shipped": study.shipped.outcome.slug,
        "positions": {run.label: run.errors.get("position") or run.outcome.slug for run in study.runs},
        "cheapest": cheapest or "none",
    }


def index_table(index: Index[LoopStudy]) -> Table:
    """Return a row for each model: mobility, outcome, errors and the cheapest settings."""
    rows = []
    for entry in index.entries.values():
        one = entry["summary"]
        places = [size if isinstance(size, str) else measured_text(1e3 * size) for size in one["positions"].values()]
        link = f"[{entry['title']}]({quote(entry['page'])})"
        rows.append((link, str(one["mobility"]), str(one["redundant"]), one["shipped"], *places, one["cheapest"]))
    labels = [f"{label} [mm]" for label in LABELS]
    headings = (
        "model",
        "mobility",
        "redundant equations",
        "run as the file has it",
        *labels,
        "cheapest within tolerance",
    )
    return table(headings, rows, labels)


def results_to_print(studies: Sequence[LoopStudy]) -> Iterator[PrintedPart]:
    """Yield the verdict on each model, what moves, how exact the runs are, and their errors."""
    for study in studies:
        yield verdict_line(f"{study.file}: {finding(study)}", study.passed)
        yield from (
            *indented_under("what moves", mobility_facts(study)),
            *indented_under("how exact", exactness_facts(study)),
            "",
        )
        yield runs_table(study)
        for title, lines in lines_to_paste(study):
            yield from (f"{title}:", Verbatim(lines))


def headline(entries: Mapping[str, Mapping[str, Any]]) -> str:
    """Say how many models are out of tolerance by their own settings, and the largest error as hardened."""
    summaries = [entry["summary"] for entry in entries.values()]
    failed = sum(one["passed"] is False for one in summaries)
    hardened = [size for one in summaries if isinstance(size := one["positions"].get("hardened"), float)]
    said = f"{failed} of {len(summaries)} models are out of tolerance with their own settings"
    return f"{said}; hardened, {len(hardened)} are off by at most {in_mm(max(hardened))}." if hardened else f"{said}."


def _live_html(part: Part[LoopStudy], anchor: str) -> str:
    """Return the HTML of the drawing that moves, under an anchor of the page; empty if nothing is drawn."""
    from conrod.report.html.moving_links import links_html

    return links_html(part.findings.drawn, anchor, part.findings.name)


LOOPS_REPORT = Kind(
    name="loops",
    findings=LoopStudy,
    title=lambda study: study.name,
    summary=_summary,
    printed=results_to_print,
    verdict=finding,
    headline=headline,
    results="loops.json",
    index_file="loops.md",
    suffix="-loops",
    live_html=_live_html,
)
