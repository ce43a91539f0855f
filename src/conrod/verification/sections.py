"""Sections of a verification report that are read off its study: criteria, code, solution, settings."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, NamedTuple

from conrod.comparison.convergence import claimed_order, numerical_uncertainty
from conrod.engines import presets_of
from conrod.exact.motion import QUANTITIES
from conrod.mechanism.units import unit_in_prose
from conrod.mjcf.loop_results import LOOP_UNITS, LOOPS, LoopStudy, loop_limits
from conrod.models.check import report as user_model
from conrod.models.check.results import ModelStudy
from conrod.models.loops import report as loops
from conrod.models.tables import report as trajectory
from conrod.models.tables.study import TableStudy
from conrod.report import numbers
from conrod.report.numbers import ROUNDING
from conrod.report.results import engine_and_preset
from conrod.report.table import Cell, ColouredCell, Table, table
from conrod.studies.validation import tables
from conrod.studies.validation.results import Qualification
from conrod.verification.page import CRITERIA, VerificationSection

MUJOCO = "mujoco"
SECTION_UNITS = {**LOOP_UNITS, LOOPS: "m"}
# Healthy presets show 3.9 to 4.2 for 4, and 1.9 to 2.0 for 2, on the machines of the catalogue.
ORDER_TOLERANCE, MIN_ERROR_WITH_ORDER, VANISHING_SHARE = 0.25, 1e-11, 0.05
TOLERANCE_REASON, CLOCK_REASON = "--tolerance", "--tolerance; phase and total: what a clock is allowed"
PATHS_REASON = "what a model written with six digits can do, or --tolerance"
NO_CRITERION = "no criterion was fixed before the run: errors are measured, not judged (--tolerance)"
ONE_RUN = "no numerical uncertainty: there are no runs at other steps"


class Refinement(NamedTuple):
    """Errors of a run at increasing numbers of steps.

    Attributes:
        run: name of the run.
        quantity: quantity of the errors.
        steps: number of steps of the judged run, per run or revolution.
        path: numbers of steps with errors; None where a run did not complete.
        formal: order that the scheme is to have; None where none is claimed."""

    run: str
    quantity: str
    steps: int
    path: tuple[tuple[int, float | None], ...]
    formal: int | None

    @property
    def finest_error(self) -> float:
        """Error of the finest completed run; infinite if none completed."""
        return next((size for _, size in reversed(self.path) if size is not None), math.inf)

    @property
    def order(self) -> float | None:
        """Observed order of the runs, or of the three finest if these converge to no error."""
        order, limit, _ = numerical_uncertainty(self.path, self.steps, self.formal) or (None, math.inf, 0.0)
        return claimed_order(self.path) or (order if limit <= VANISHING_SHARE * self.finest_error else None)

    @property
    def is_off(self) -> bool:
        """True if a formal order is claimed but not observed, at errors above rounding."""
        off = self.formal is not None and abs((self.order or 0.0) - self.formal) > ORDER_TOLERANCE
        return off and self.finest_error > MIN_ERROR_WITH_ORDER


def all_refinements(study: Any) -> Iterator[Refinement]:
    """Yield the refinements of all runs of a study, quantity by quantity."""
    match study:
        case TableStudy():
            return
        case LoopStudy():
            for run in study.runs:
                same = [one for one in (*study.runs, *study.steps) if one.label == run.label]
                for name in run.errors:
                    pairs = sorted((round(study.seconds / one.timestep), one.errors.get(name)) for one in same)
                    order = _formal_orders(MUJOCO, run.label).get(name) if name == "position" else None
                    yield Refinement(run.label, name, round(study.seconds / run.timestep), tuple(pairs), order)
            return
        case ModelStudy():
            found = [
                (run.label, round(run.steps_per_revolution), study.refined.get(run.label, ()), MUJOCO, run.label)
                for run in study.runs.values()
            ]
        case _:
            found = [
                (
                    " ".join(engine_and_preset(one)),
                    one.steps_per_revolution or 0,
                    one.refinement,
                    one.engine,
                    one.preset,
                )
                for one in study.results
            ]
    contact = bool(study.scene.mechanism().cam_contacts)
    for name, steps, points, engine, preset in found:
        for quantity in QUANTITIES if points else ():
            path = tuple((point.steps_per_revolution, getattr(point, quantity)) for point in points)
            yield Refinement(
                name, quantity, steps, path, None if contact else _formal_orders(engine, preset).get(quantity)
            )


def _formal_orders(engine: str, preset: str | None) -> Mapping[str, int]:
    found = presets_of(engine).get(preset or "")
    return {} if found is None else found.order


def study_sections(study: Any) -> tuple[dict[str, VerificationSection], list[str]]:
    """Return the sections that a study itself fills, by name, and its open deviations."""
    refined, lengths = list(all_refinements(study)), {} if isinstance(study, LoopStudy) else study.scene.lengths
    judged = _run_criteria(study)
    rows, full = [], {}
    for run, limits, of, _ in judged:
        for name, allowed in limits.items():
            rows.append((run, name, *criterion_cells(name, allowed, of(name), lengths)))
            full[f"{run} {name}"] = _criterion_text(name, allowed, lengths)
    criteria = table(("run", "quantity", "criterion", "found", "within"), rows, ("criterion", "found"), names=2)
    laws = dict.fromkeys(f"{run}: {law}" for run, limits, _, law in judged if limits)
    orders = [(one.run, one.quantity, str(one.formal), *_order_cells(one)) for one in refined if one.formal]
    results, settings, proofs = _kind_sections(study)
    code = table(("run", "quantity", "formal order", "observed", "agreement"), orders, names=2)
    planted = _qualifications(study)
    noticed = (tables.noticed_table("defects", planted),) if planted else ()
    found = {
        CRITERIA: VerificationSection((criteria,), tuple(laws) or (NO_CRITERION,), full),
        "code": VerificationSection(
            (code, *noticed), (*proofs, *(() if code else ("no formal order is claimed for these runs",)))
        ),
        "solution": VerificationSection(
            (*results, _uncertainty_table(refined, lengths)), () if refined else (ONE_RUN,)
        ),
        "settings": settings,
    }
    off = [
        f"{one.run}: the order of {one.quantity} is not the formal {one.formal}, observed is {numbers.order(one.order)}"
        for one in refined
        if one.is_off
    ]
    off += [
        f"{run}: a planted defect is not noticed: {one.defect} {numbers.defect_size_text(one.size, one.unit)}".rstrip()
        for run, qualified in planted.items()
        for one in (*qualified.motion, *qualified.forces)
        if one.visible and not one.by
    ]
    # A model's paths and clock are judged in any case.
    unjudged = study.tolerance is None if isinstance(study, ModelStudy) else not criteria
    return found, [*off, *([NO_CRITERION] if unjudged else [])]


def _qualifications(study: Any) -> dict[str, Qualification]:
    """Verdicts on planted defects by run, of a study that was made with `--qualify`; empty for any other."""
    if isinstance(study, ModelStudy):
        return {} if study.qualified is None else {"check of the model": study.qualified}
    found = ((one, getattr(one, "qualified", None)) for one in getattr(study, "results", ()))
    return {" ".join(engine_and_preset(one)): qualified for one, qualified in found if qualified is not None}


def _error_text(name: str, size: float | None, lengths: Mapping[str, float]) -> str:
    """Return an error as text, in SI if no lengths normalise it."""
    if lengths or size is None:
        return numbers.error(name, size, lengths)
    return f"{numbers.measured_text(size)} {unit_in_prose(SECTION_UNITS[name])}"


def criterion_cells(
    name: str, allowed: float, size: float | None, lengths: Mapping[str, float]
) -> tuple[Cell, Cell, Cell]:
    """Return a criterion, the measured size in equal digits and notation, and whether the size is within."""
    factor, unit = 1.0, "" if lengths else f" {unit_in_prose(SECTION_UNITS.get(name, ''))}"
    if name == "phase":
        factor, unit = numbers.SHOWN_UNITS["rad"][1], " deg"
    texts = _texts_alike(allowed, size, factor, unit)
    if name in numbers.QUANTITIES_OVER_L and lengths:
        # Several points have several L: the largest of these gives a bound.
        bound = "<= " if len(set(lengths.values())) > 1 else ""
        in_mm = _texts_alike(allowed, size, 1e3 * max(lengths.values()), " mm")
        texts = [f"{text} ({bound if mm[0].isdigit() else ''}{mm})" for text, mm in zip(texts, in_mm, strict=True)]
    if size is None:
        return texts[0], numbers.MISSING, numbers.MISSING
    return texts[0], texts[1], "yes" if size <= allowed else ColouredCell("NO", "bad")


def _texts_alike(allowed: float, size: float | None, factor: float, unit: str) -> list[str]:
    """Return two sizes in three digits, both with an exponent if one needs it; of an error below rounding a bound."""
    shown = [size] if size is not None and math.isfinite(size) and size >= ROUNDING else []
    sizes = [factor * one for one in (allowed, *shown)]
    plain = all(numbers.PLAIN_RANGE[0] <= one < numbers.PLAIN_RANGE[1] for one in sizes)
    found = [numbers.three_digits(one, plain) + unit for one in sizes]
    return found if shown else [*found, f"{numbers.scaled_text(size, factor)}{unit if size is not None else ''}"]


def _criterion_text(name: str, allowed: float, lengths: Mapping[str, float]) -> str:
    """Return a criterion as text in six digits."""
    if name == "phase":
        return f"{math.degrees(allowed):.6g} deg"
    return f"{allowed:.6g}" if lengths else f"{allowed:.6g} {unit_in_prose(SECTION_UNITS[name])}"


def _order_cells(one: Refinement) -> tuple[str, Cell]:
    below = "at rounding, not shown" if one.order is None else "yes"
    return numbers.order(one.order), ColouredCell("NO", "bad") if one.is_off else below


def _run_criteria(study: Any) -> list[tuple[str, Mapping[str, float], Callable[[str], float | None], str]]:
    """List the criteria of each run: name, tolerances, errors by quantity, and reason."""
    match study:
        case ModelStudy():
            paths = {"position": study.kinematic_tolerance}
            proof = ("kinematic mode", paths, lambda _: study.identity.largest, PATHS_REASON)
            own = study.driven_run
            return [
                proof,
                *([("its own settings", study.limits, partial(study.judged_error, own), CLOCK_REASON)] if own else []),
            ]
        case LoopStudy():
            return [
                (run.label, loop_limits(study.question.tolerance), run.judged_error, TOLERANCE_REASON)
                for run in study.runs
            ]
        case TableStudy():
            return [("the table", study.tolerance, study.largest, CLOCK_REASON)]
    return [(" ".join(engine_and_preset(r)), r.limits, r.judged_error, r.tolerance.reason) for r in study.results]


def _kind_sections(study: Any) -> tuple[tuple[Table, ...], VerificationSection, tuple[str, ...]]:
    """Return tables of results, the section on settings, and checks of the model before runs."""
    match study:
        case ModelStudy():
            frame, wiring, paths, settings = user_model.findings(study).values()
            return (user_model.runs_table(study),), VerificationSection((), (*frame, *settings)), (*wiring, *paths)
        case LoopStudy():
            moves, exact = tuple(loops.mobility_facts(study)), tuple(loops.exactness_facts(study))
            return (loops.runs_table(study),), VerificationSection((), moves), exact
        case TableStudy():
            lines = (trajectory.summary_line(study), *trajectory.findings(study))
            return (
                (trajectory.errors_table(study),),
                VerificationSection((trajectory.columns_table(study.columns),), lines),
                (),
            )
        case _:
            used = VerificationSection(tuple(tables.settings_tables(study)), tuple(tables.added_words(study)))
            return (), used, ()


def _uncertainty_table(refined: list[Refinement], lengths: Mapping[str, float]) -> Table:
    rows = []
    for one in refined:
        if (found := numerical_uncertainty(one.path, one.steps, one.formal)) is not None:
            order, limit, size = found
            found_at = dict(one.path).get(one.steps)
            shown = [_error_text(one.quantity, value, lengths) for value in (found_at, limit, size)]
            rows.append((one.run, one.quantity, *shown[:2], f"± {shown[2]}", numbers.order(order)))
    head = ("found", "at a step of zero", "numerical uncertainty", "order of the three finest")
    return table(("run", "error", *head), rows, head, names=2)
