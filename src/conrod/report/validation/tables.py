"""The tables of a validation, on the console and on a scene's page."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial

from conrod.engines.engine import STOCK
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.results import name_of, refinement_table, results_table, verdict_cell
from conrod.report.table import Cell, Table, Toned, table
from conrod.runs.convergence import PAIRS_AGREE, observed_order
from conrod.runs.trajectory import Outcome
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.validation.results import Noticed, Qualified, SceneStudy, ValidationResult

MEASURES = ("max", "rms", "final")
JUDGED = (*QUANTITIES, "total", "velocity_rms", "phase")
TITLE = "largest error over the run, normalised by L, ω L, ω² L"


def dynamic(study: SceneStudy) -> list[ValidationResult]:
    """The results of real time stepping."""
    return [r for r in study.results if r.mode == "dynamic"]


def verdicts_table(studies: Sequence[SceneStudy]) -> Table:
    """A row for each result: largest errors over the observed points, observed orders, verdict."""

    def orders(run: ValidationResult) -> str:
        return "" if run.order is None else ", ".join(numbers.order(run.order[q]) for q in QUANTITIES)

    lengths = {study.name: study.scene.lengths for study in studies}
    columns: dict[str, Callable[[ValidationResult], str]] = {
        "steps/rev": lambda r: str(r.steps_per_revolution or ""),
        "position": partial(_largest, quantity="position"),
        numbers.IN_MM: lambda r: millimetres(r, lengths[r.scene]),
        **{q: partial(_largest, quantity=q) for q in QUANTITIES[1:]},
        "order x, v, a": orders,
    }
    return results_table(studies, columns, TITLE)


def millimetres(run: ValidationResult, lengths: Mapping[str, float]) -> str:
    """The largest position error of a run in mm."""
    errors = {point: (sizes["position"] or {}).get("max") for point, sizes in (run.errors or {}).items()}
    return numbers.in_mm(errors, lengths)


def added_words(study: SceneStudy) -> list[str]:
    """What the stock preset has beside the engine as it comes, and what drives the engine without it."""
    found = []
    for run in study.results:
        settings, engine = run.settings or {}, engine_title(run.engine)
        if run.preset == STOCK and (flywheel := settings.get("armature")):
            found.append(
                f"{engine} stock is {engine} as it comes, and a drive: a flywheel of {numbers.quantity(flywheel)} "
                f"kg m² on the crank, and a solver tolerance of {settings['tolerance']:g}"
            )
    return found


def _largest(run: ValidationResult, quantity: str, measure: str = "max") -> str:
    return numbers.measured(run.largest(quantity, measure))


def _table(
    study: SceneStudy, needs: str, head: Sequence[str], cells: Callable[[ValidationResult], Iterable[str]]
) -> Table:
    """A row for each run that has something: engine, preset, and what is found of it."""
    rows = [(*name_of(r), *cells(r)) for r in dynamic(study) if getattr(r, needs) is not None]
    return table(["engine", "preset", *head], rows)


def errors_table(study: SceneStudy, point: str) -> Table:
    """Max, rms and final value of each error of a point."""
    head = [f"{q}: max, rms, final" for q in (*QUANTITIES, "total")]
    head += [f"{q}: max, rms, final [mm]" for q in numbers.PLACES]

    def cells(run: ValidationResult) -> list[str]:
        sizes, of = (run.errors or {})[point], {point: study.scene.lengths[point]}
        over = [_sizes(sizes.get(q), numbers.measured) for q in (*QUANTITIES, "total")]
        return [*over, *(_sizes(sizes.get(q), partial(numbers.in_mm, lengths=of)) for q in numbers.PLACES)]

    return _table(study, "errors", head, cells)


def _sizes(size: Mapping[str, float] | None, shown: Callable[[float], str]) -> str:
    return numbers.MISSING if size is None else ", ".join(shown(size[m]) for m in MEASURES)


def orders_table(study: SceneStudy) -> Table:
    """Errors along the refinement path and the order that they show."""
    return refinement_table(
        dynamic(study),
        "quantity",
        lambda _: QUANTITIES,
        lambda _, point, quantity: getattr(point, quantity),
        partial(_order, lengths=study.scene.lengths),
        partial(numbers.error, lengths=study.scene.lengths),
    )


def _order(run: ValidationResult, quantity: str, lengths: Mapping[str, float]) -> str:
    """The claimed order, or what the errors do instead."""
    claimed = None if run.order is None else run.order.get(quantity)
    if claimed is not None:
        return numbers.order(claimed)
    stable = [(p.steps_per_revolution, e) for p in run.refinement if (e := getattr(p, quantity)) is not None]
    if len(stable) < 2:
        return numbers.MISSING
    pairs = [p for p in observed_order([n for n, _ in stable], [e for _, e in stable]).pairs if p is not None]
    flat = stable[-1][1] < numbers.ROUNDING or (pairs and max(pairs[-2:]) <= PAIRS_AGREE)
    return f"none: plateau at {numbers.error(quantity, stable[-1][1], lengths)}" if flat else "none claimed"


def closure_table(study: SceneStudy) -> Table:
    """Closure, phase and drive of every run."""
    head = ["gap, max / L", "gap rate, max / (ω L)", "gap acceleration, max / (ω² L)", "gap [mm]"]
    head += ["phase [deg], max", "final", "speed ripple", "angular acceleration / ω²"]
    longest = {"gap": max(study.scene.lengths.values())}

    def cells(r: ValidationResult) -> list[str]:
        gap = numbers.in_mm((r.closure or {}).get("position"), longest)
        phase = [numbers.in_degrees((r.phase or {}).get(measure)) for measure in ("max", "final")]
        return [*_values(r.closure, QUANTITIES), gap, *phase, *_values(r.drive, ("speed", "acceleration"))]

    return _table(study, "closure", head, cells)


def prediction_table(study: SceneStudy) -> Table:
    """Errors predicted from the joints alone, beside the measured ones."""
    head = [f"{q}: measured, predicted, difference" for q in QUANTITIES]
    head += ["position: measured, predicted, difference [mm]"]

    def cells(run: ValidationResult) -> list[str]:
        found = [_predicted(run, q) for q in QUANTITIES]
        shown = [[numbers.measured(size) for size in sizes] for sizes in found]
        lengths = study.scene.lengths
        in_mm = [millimetres(run, lengths), *(numbers.in_mm(size, lengths) for size in found[0][1:])]
        return [", ".join(sizes) for sizes in (*shown, in_mm)]

    return _table(study, "prediction", head, cells)


def _predicted(run: ValidationResult, quantity: str) -> list[float | None]:
    found = (run.prediction or {})[quantity]
    return [run.largest(quantity), found.get("predicted"), found.get("difference")]


def _values(values: Mapping[str, float | None] | None, names: tuple[str, ...]) -> list[str]:
    return [numbers.measured(None if values is None else values.get(name)) for name in names]


def kinematic_table(study: SceneStudy) -> Table:
    """Kinematic mode: the proof of the model."""
    head = ["engine", "position error / L, max", numbers.IN_MM, "velocity error / (ω L), max", "gap / L, max"]
    head += ["gap [mm]", "position allowed", "velocity allowed", "because", "verdict"]
    lengths = study.scene.lengths
    longest = {"gap": max(lengths.values())}
    rows = [
        (
            *(engine_title(r.engine), _largest(r, "position"), millimetres(r, lengths), _largest(r, "velocity")),
            *_values(r.closure, ("position",)),
            numbers.in_mm((r.closure or {}).get("position"), longest),
            *(numbers.error(q, getattr(r.tolerance, q), lengths) for q in ("position", "velocity")),
            r.tolerance.reason,
            verdict_cell(r),
        )
        for r in study.results
        if r.mode == "kinematic"
    ]
    return table(head, rows)


def tolerances_table(study: SceneStudy) -> Table:
    """The errors allowed in dynamic mode, and why."""
    rows = []
    for r in dynamic(study):
        unsupported = r.outcome == Outcome.UNSUPPORTED.slug
        because = r.tolerance.reason or ("unsupported" if unsupported else "not judged")
        allowed = (numbers.allowed(name, getattr(r.tolerance, name), study.scene.lengths) for name in JUDGED)
        rows.append((*name_of(r), *allowed, because))
    return table(["engine", "preset", *(name.replace("_", ", ") for name in JUDGED), "because"], rows)


QUALIFICATION = "planted into these runs, and judged again: noticed or not, and the smallest size that would be"


def qualification_table(study: SceneStudy) -> Table:
    """What the verdicts notice, a row for each defect and a column for each run; no row where it was not asked for."""
    runs = {" ".join(name_of(r)): r.qualified for r in study.results if r.qualified is not None}
    return noticed_table(study.name, runs)


def noticed_table(name: str, runs: Mapping[str, Qualified]) -> Table:
    """A row for each defect, a column for each verdict by its name."""
    by_run = [{(kind, one.defect): one for kind, some in vars(q).items() for one in some} for q in runs.values()]
    rows = [
        (
            defect + (" (forces)" if kind == "forces" else ""),
            numbers.sized(planted.size, planted.unit) or "one",
            *(_noticed_cell(found.get((kind, defect))) for found in by_run),
        )
        for (kind, defect), planted in {key: one for found in by_run for key, one in found.items()}.items()
    ]
    return table(["defect", "size", *runs], rows, title=f"{name}: {QUALIFICATION}")


def _noticed_cell(found: Noticed | None) -> Cell:
    if found is None:
        return "not judged"
    if not found.visible:
        return "cannot be seen"
    where = f" ({found.where})" if found.where else ""
    if not found.unit:
        return Toned(f"noticed: {', '.join(found.by)}", "good") if found.by else Toned("NOT NOTICED", "bad")
    least = "" if found.smallest is None else f", from {numbers.sized(found.smallest, found.unit)}"
    return Toned(f"noticed{least}{where}", "good") if found.by else Toned(f"NOT NOTICED{least}{where}", "bad")


# -- settings --------------------------------------------------------------------------------------------------------

MEANINGS = {
    "timestep": "time step [s]",
    "integrator": "integrator",
    "solver": "constraint solver",
    "iterations": "solver iterations, at most",
    "tolerance": "solver tolerance; the drive's armature forces 0",
    "solref": "loop closures: time constant [s], damping ratio",
    "solimp": "loop closures: impedance",
    "hardening": "factor on the compiled inverse weights, which scale the regularisation",
    "gravity": "gravity as in the real machine",
    "armature": "flywheel of the drive [kg m²]",
    "autoreset": "the engine may reset the state by itself",
    "contact_solref": "contact: time constant [s], damping ratio",
    "contact_solimp": "contact: impedance",
    "cam_vertices": "vertices of the cam's polygon, about",
    "error_bias": "share of a joint's error left after 1 s",
    "collision_bias": "share of a contact's error left after 1 s",
    "collision_slop": "overlap that contacts may keep [m]",
    "refsafe": "a time constant below two steps is raised to them",
}
OF_CONTACT = {"contact_solref", "contact_solimp", "cam_vertices", "collision_bias", "collision_slop"}
OF_LOOPS = {"solref", "solimp", "hardening"}
NAMED_ELSEWHERE = {"preset", "steps_per_revolution", "rod"}  # the last one says "body" of all


def settings_tables(study: SceneStudy, has_contact: bool) -> list[tuple[str, Table]]:
    """A heading and a table for each engine, with a column for each preset."""
    left_out = NAMED_ELSEWHERE | (OF_LOOPS if has_contact else OF_CONTACT)
    found = []
    for engine in dict.fromkeys(r.engine for r in dynamic(study)):
        runs = [r for r in dynamic(study) if r.engine == engine and r.settings is not None]
        if runs:
            found.append((f"{engine_title(engine)} {runs[0].engine_version}", _settings_table(runs, left_out)))
    return found


def _settings_table(runs: Sequence[ValidationResult], left_out: set[str]) -> Table:
    rows = [
        (f"`{name}`", MEANINGS.get(name, ""), *(numbers.setting((run.settings or {}).get(name)) for run in runs))
        for name in runs[0].settings or {}
        if name not in left_out
    ]
    return table(["setting", "meaning", *(run.preset or "" for run in runs)], rows)
