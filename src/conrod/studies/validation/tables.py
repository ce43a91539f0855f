"""The tables of a validation, on the console and on a scene's page."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_style
from conrod.engines.engine import STOCK
from conrod.exact.link_rotations import ROTATIONS, rotation_scales
from conrod.exact.motion import QUANTITIES
from conrod.execution.families import VALUE_SIGN
from conrod.report import numbers
from conrod.report.results import distrusted_scenes, engine_and_preset, results_table, summary_words
from conrod.report.table import VERDICT, Cell, ColouredCell, Table, table
from conrod.report.terminal import PrintedPart, verdict_line
from conrod.studies.validation.results import DefectVerdict, Qualification, SceneStudy, ValidationResult

JUDGED = (*QUANTITIES, "total", "velocity_rms", "phase")
TITLE = "largest error over the run, normalised by L, ω L, ω² L"
MAX_OPENING_LINES = 8


def dynamic_results(study: SceneStudy) -> list[ValidationResult]:
    """Return the results of dynamic mode, which steps through time."""
    return [r for r in study.results if r.mode == "dynamic"]


def verdicts_table(studies: Sequence[SceneStudy]) -> Table:
    """Return a row for each result: largest errors, observed orders, verdict."""

    def orders(run: ValidationResult) -> str:
        return "" if run.order is None else ", ".join(numbers.order(run.order[q]) for q in QUANTITIES)

    lengths = {study.name: study.scene.lengths for study in studies}
    columns: dict[str, Callable[[ValidationResult], str]] = {
        "steps/rev": lambda r: str(r.steps_per_revolution or ""),
        "position": partial(_largest_text, quantity="position"),
        numbers.IN_MM: lambda r: position_in_mm(r, lengths[r.scene]),
        **{q: partial(_largest_text, quantity=q) for q in QUANTITIES[1:]},
    }
    if any(run.links for study in studies for run in study.results):
        columns["link angle"] = _link_text
    columns["order x, v, a"] = orders
    return results_table(studies, columns, TITLE)


def family_table(members: Sequence[SceneStudy]) -> Table:
    """Return a row for each member of a family: its largest position errors by engine and preset, and its verdict."""
    runs = list(dict.fromkeys(engine_and_preset(r) for study in members for r in study.results))
    rows = []
    for study in members:
        cells = {engine_and_preset(r): _family_cell(r) for r in study.results}
        rows.append((study.name, *(cells.get(run, "") for run in runs), _family_verdict(study)))
    columns = [" ".join(run) for run in runs]
    return table(("member", *columns, VERDICT), rows, columns, "largest position error over the run, over L", names=1)


def _family_cell(run: ValidationResult) -> Cell:
    text = numbers.measured_text(run.largest("position")) if run.completed else run.outcome
    return ColouredCell(text, "bad") if run.passed is False else text


def _family_verdict(study: SceneStudy) -> Cell:
    judged = [r for r in study.results if r.passed is not None]
    if failed := [" ".join(engine_and_preset(r)) for r in judged if not r.passed]:
        return ColouredCell(f"OUT OF TOLERANCE: {', '.join(failed)}", "bad")
    return ColouredCell("within tolerance", "good") if judged else "not judged"


def _is_unjudged(run: ValidationResult) -> bool:
    return run.passed is None and run.completed


def _failed_or_alone(study: SceneStudy) -> SceneStudy:
    """Return the study, of a member of a family with the results alone that did not pass."""
    if VALUE_SIGN not in study.name:
        return study
    return replace(study, results=tuple(r for r in study.results if r.passed is False))


def position_in_mm(run: ValidationResult, lengths: Mapping[str, float]) -> str:
    """Return the largest position error of a run in mm."""
    errors = {point: (sizes["position"] or {}).get("max") for point, sizes in (run.errors or {}).items()}
    return numbers.in_mm(errors, lengths)


def added_words(study: SceneStudy) -> list[str]:
    """List the additions of the stock preset to the engine's defaults."""
    found = []
    for run in study.results:
        settings, engine = run.settings or {}, engine_style(run.engine).title
        if run.preset == STOCK and (flywheel := settings.get("armature")):
            found.append(
                f"{engine} stock is {engine} as it comes, and a drive: a flywheel of {numbers.quantity(flywheel)} "
                f"kg m² on the crank, and a solver tolerance of {settings['tolerance']:g}"
            )
    return found


def _link_text(run: ValidationResult) -> str:
    """Return the largest error of a link's rotation over its range, with the link's name; empty without links."""
    link, size = run.largest_rotation("rotation")
    return f"{numbers.measured_text(size)} {link}" if link else ""


def links_table(study: SceneStudy) -> Table:
    """Return a row for each run and driven link: its largest errors of rotation, in degrees and normalised."""
    scales = rotation_scales(study.scene.kinematics) if any(run.links for run in study.results) else {}
    rows = []
    for run in dynamic_results(study):
        for link, errors in (run.links or {}).items():
            most = [errors[quantity]["max"] for quantity in ROTATIONS]
            allowed = [getattr(run.tolerance, quantity) for quantity in ROTATIONS]
            off = numbers.scaled_text(most[0], math.degrees(scales[link]))
            pairs = [
                f"{numbers.measured_text(size)}{'' if limit is None else f' <= {numbers.measured_text(limit)}'}"
                for size, limit in zip(most, allowed, strict=True)
            ]
            rows.append((*engine_and_preset(run), link, numbers.quantity(math.degrees(scales[link])), off, *pairs))
    head = ("R [deg]", "rotation [deg]", *(quantity.replace("_", " ") for quantity in ROTATIONS))
    return table(["engine", "preset", "link", *head], rows)


def _largest_text(run: ValidationResult, quantity: str) -> str:
    return numbers.measured_text(run.largest(quantity))


def points_table(study: SceneStudy) -> Table:
    """Return a row for each run and point: its largest errors."""
    rows = []
    for run in dynamic_results(study):
        for point, sizes in (run.errors or {}).items():
            of = {point: study.scene.lengths[point]}
            most = {q: (sizes.get(q) or {}).get("max") for q in (*QUANTITIES, "total")}
            places = [numbers.in_mm(most[q], of) for q in ("position", "total")]
            rms = numbers.measured_text((sizes["velocity"] or {}).get("rms"))
            rates = [numbers.measured_text(most[q]) for q in QUANTITIES[1:]]
            rows.append((*engine_and_preset(run), point, *places, *rates, rms))
    head = (numbers.IN_MM, "at time t [mm]", "velocity", "acceleration", "velocity, rms")
    return table(["engine", "preset", "point", *head], rows)


def joints_table(study: SceneStudy) -> Table:
    """Return a row for each run: gaps of joints, errors predicted from them, phase, ripple."""
    lengths = study.scene.lengths
    rows = []
    for run in dynamic_results(study):
        if run.closure is not None:
            gap = numbers.in_mm(run.closure["position"], {"gap": max(lengths.values())})
            predicted = (run.prediction or {}).get("position", {})
            found = [numbers.in_mm(predicted.get(name), lengths) for name in ("predicted", "difference")]
            phase = numbers.in_degrees((run.phase or {}).get("max"))
            ripple = numbers.measured_text((run.drive or {}).get("speed"))
            rows.append((*engine_and_preset(run), gap, position_in_mm(run, lengths), *found, phase, ripple))
    errors = ("gap [mm]", "error [mm]", "by the gaps alone [mm]", "difference [mm]")
    return table(["engine", "preset", *errors, "phase [deg]", "speed ripple"], rows)


def tolerances_table(study: SceneStudy) -> Table:
    """Return a row for each result: its tolerances and their reason."""
    rows = []
    for r in study.results:
        unsupported = r.outcome == Outcome.UNSUPPORTED.slug
        because = r.tolerance.reason or ("unsupported" if unsupported else "not judged")
        allowed = (numbers.allowed_text(name, getattr(r.tolerance, name), study.scene.lengths) for name in JUDGED)
        rows.append((*engine_and_preset(r), *allowed, because))
    return table(["engine", "preset", *(name.replace("_", ", ") for name in JUDGED), "because"], rows)


QUALIFICATION = "planted into these runs, and judged again: noticed or not, and the smallest size that would be"


def qualification_table(study: SceneStudy) -> Table:
    """Return a row for each planted defect: whether each run's verdict notices it."""
    runs = {" ".join(engine_and_preset(r)): r.qualified for r in study.results if r.qualified is not None}
    return noticed_table(study.name, runs)


def noticed_table(name: str, runs: Mapping[str, Qualification]) -> Table:
    """Return a row for each planted defect, a column for each verdict."""
    by_run = [{(kind, one.defect): one for kind, some in vars(q).items() for one in some} for q in runs.values()]
    rows = [
        (
            defect + (" (forces)" if kind == "forces" else ""),
            numbers.defect_size_text(planted.size, planted.unit) or "one",
            *(_noticed_cell(found.get((kind, defect))) for found in by_run),
        )
        for (kind, defect), planted in {key: one for found in by_run for key, one in found.items()}.items()
    ]
    return table(["defect", "size", *runs], rows, title=f"{name}: {QUALIFICATION}")


def _noticed_cell(found: DefectVerdict | None) -> Cell:
    if found is None:
        return "not judged"
    if not found.visible:
        return "cannot be seen"
    where = f" ({found.where})" if found.where else ""
    if not found.unit:
        return (
            ColouredCell(f"noticed: {', '.join(found.by)}", "good") if found.by else ColouredCell("NOT NOTICED", "bad")
        )
    least = "" if found.smallest is None else f", from {numbers.defect_size_text(found.smallest, found.unit)}"
    return (
        ColouredCell(f"noticed{least}{where}", "good")
        if found.by
        else ColouredCell(f"NOT NOTICED{least}{where}", "bad")
    )


# -- settings --------------------------------------------------------------------------------------------------------

CONTACT_SETTINGS = {"contact_solref", "contact_solimp", "cam_vertices", "collision_bias", "collision_slop"}
LOOP_SETTINGS = {"solref", "solimp", "hardening"}
RUN_SETTINGS = {"preset", "steps_per_revolution", "rod"}  # printed elsewhere; `rod` is "body" for all


def settings_tables(study: SceneStudy) -> list[Table]:
    """Return a table of settings for each engine, with a column for each preset."""
    left_out = RUN_SETTINGS | (LOOP_SETTINGS if study.scene.mechanism().cam_contacts else CONTACT_SETTINGS)
    found = []
    for engine in dict.fromkeys(r.engine for r in dynamic_results(study)):
        runs = {
            r.preset or "": r.settings for r in dynamic_results(study) if r.engine == engine and r.settings is not None
        }
        names = [name for name in next(iter(runs.values()), {}) if name not in left_out]
        rows = [(f"`{name}`", *(numbers.setting(settings.get(name)) for settings in runs.values())) for name in names]
        if rows:
            found.append(
                table([f"{engine_style(engine).title} setting", *runs], rows, title=engine_style(engine).title)
            )
    return found


def _opening_lines(studies: Sequence[SceneStudy]) -> Iterator[PrintedPart]:
    """Yield how far off each scene's results are, for a few scenes; of many, the table tells."""
    if len(studies) > MAX_OPENING_LINES:
        return
    for study in studies:
        if not any(run.distrust for run in study.results):
            passed = None if all(run.passed is None for run in study.results) else study.passed
            yield verdict_line(f"{study.name}: {summary_words(study.results, study.scene.lengths)}", passed)


def results_to_print(studies: Sequence[SceneStudy]) -> Iterator[PrintedPart]:
    """Yield errors, orders and verdicts of all results, and why some are not judged."""
    members = [study for study in studies if VALUE_SIGN in study.name]
    yield from distrusted_scenes(studies)
    yield from _opening_lines([study for study in studies if VALUE_SIGN not in study.name])
    yield family_table(members)
    if unjudged := dict.fromkeys(
        " ".join(engine_and_preset(r)) for one in members for r in one.results if _is_unjudged(r)
    ):
        yield f"measured, not judged: {', '.join(unjudged)}"
    # A family has its errors in one table; what is out of tolerance in it is shown whole.
    yield verdicts_table([study for study in map(_failed_or_alone, studies) if study.results])
    yield from (f"{study.name}: {words}" for study in studies for words in added_words(study))
    reasons = dict.fromkeys(
        (result.scene, result.tolerance.reason)
        for study in studies
        for result in study.results
        if result.passed is None and result.tolerance.reason
    )
    yield from (f"{scene}: tolerances: {reason}" for scene, reason in reasons)
    yield from map(qualification_table, studies)
