"""An FMU judged: run at several steps or tolerances, and the trajectory of the finest judged as a table is."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from conrod.errors import InvalidInput, named_values, nearest, unknown_choice
from conrod.own.fmu.unit import Description, Order, Variable, read_fmu, simulate
from conrod.own.tables.columns import LISTED, Column, Request, check_units_used, column_of
from conrod.own.tables.headings import AXES, CRANK_ANGLE, TIME, Target, bare_unit, targets
from conrod.own.tables.reading import MOST_ROWS, Reading, reading_of
from conrod.own.tables.samples import ERRORS, Alignment, Exact
from conrod.own.tables.study import TableStudy, ToolRun, study_table
from conrod.scenes import Scene
from conrod.studies.execution import isolation

COARSER = (1, 2, 4)  # times the communication step, the finest first
CVODE_TOLERANCES = (1e-9, 1e-7, 1e-5)  # relative; the last is FMPy's own


def study_fmu(
    path: Path,
    scene: tuple[str, Scene],
    asked: Request,
    mode: str | None,
    steps: int,
    revolutions: float,
    estimate: Sequence[str],
    tolerance: Mapping[str, float] | None,
    timeout: float,
) -> TableStudy:
    """Run an FMU and judge it; each run has a process of its own.

    Args:
        scene: its name and itself.
        mode: None for the first that it has.
        steps: per revolution.
        timeout: longest time of a run [s].

    Raises:
        InvalidInput: it or an option cannot be used, or its finest run does not complete.
    """
    machine = scene[1]
    with TemporaryDirectory(prefix="conrod-fmu-") as folder:
        fmu = isolation.confined(read_fmu, path, folder)
        mode = fmu.modes[0] if mode is None else mode
        if mode not in fmu.modes:
            raise unknown_choice("mode in --preset", mode, fmu.modes)
        columns = choose_variables(fmu, tuple(machine.lengths), asked)
        used = [fmu.variables[column.index - 1] for column in columns[1:]]
        unused = tuple(one.name for one in fmu.variables if one.output and one not in used)[:LISTED]

        def reading(order: Order) -> Reading:
            values = isolation.confined(simulate, path, folder, order, used, timeout=timeout)
            form = f"FMI {fmu.version} {order}{f'; {fmu.tool}' if fmu.tool else ''}"
            return reading_of(columns, values, np.arange(1, len(values) + 1), unused, form)

        finest, *others = _orders(mode, machine, steps, revolutions)
        table = study_table(str(path), *scene, reading(finest), estimate, tolerance)
        alignment = table.estimation.alignment if table.estimation else Alignment()
        sizes = {name: size for name in ERRORS if (size := table.largest(name)) is not None}
        runs = [ToolRun(str(finest), finest.steps, sizes)]
        for order in others:
            try:
                exact = Exact(reading(order).observed, machine, alignment)
                runs.append(ToolRun(str(order), order.steps, {name: exact.largest(name) for name in sizes}))
            except InvalidInput as error:
                runs.append(ToolRun(str(order), order.steps, {}, str(error).removeprefix(f"{path}: ")))
    notes = [f"it has {other}, too: --preset {other}" for other in fmu.modes if other != mode]
    return replace(table, runs=tuple(runs), notes=(*table.notes, *notes))


def _orders(mode: str, scene: Scene, steps: int, revolutions: float) -> list[Order]:
    """The runs of a mode, the finest first; of an input that makes one pass, that pass."""
    span = scene.kinematics.mechanism.driver.span
    start, stop = (0.0, revolutions * scene.period) if span is None else sorted(angle / scene.speed for angle in span)
    turns = (stop - start) / scene.period
    if not 2 * max(COARSER) <= round(turns * steps) < MOST_ROWS:
        raise InvalidInput(
            f"--steps-per-rev {steps}: in {turns:.6g} turns {2 * max(COARSER)} to {MOST_ROWS - 1} steps are taken"
        )
    if mode == "model-exchange":
        return [Order(mode, None, one, start, stop, round(turns * steps)) for one in CVODE_TOLERANCES]
    return [Order(mode, round(steps / k), None, start, stop, round(turns * steps / k)) for k in COARSER]


# -- its variables as columns ------------------------------------------------------------------------------------------
BETWEEN = re.compile(r",(?![^\[]*\])")  # a comma that is not in the brackets of T[1,2]
COMPARED = 20_000  # names among which a mistyped one is looked for


def in_columns(given: Sequence[str], crank: str | None, points: Sequence[str]) -> list[str]:
    """`--point C=X,Y` and `--crank ANGLE` as `--column` has them, C.x=X; one of X and Y may be empty.

    Raises:
        InvalidInput: a point that the scene has not, or three variables for one.
    """
    columns = [] if crank is None else [f"{CRANK_ANGLE}={crank}"]
    for point, text in named_values(given, "--point", f"--point {points[0]}=X,Y", "observed point", points).items():
        names = [name.strip() for name in BETWEEN.split(text)]
        if len(names) > len(AXES):
            raise InvalidInput(f"--point {point}={text}: give its x and y; velocities go by --column {point}.vx=...")
        columns += [f"{point}.{axis}={name}" for axis, name in zip(AXES, names, strict=False) if name]
    return columns


def choose_variables(fmu: Description, points: Sequence[str], asked: Request) -> list[Column]:
    """The columns of an FMU's runs, in the order of `targets`; the time is the first.

    An output that is called as a quantity of the scene is, `C.x`, is that quantity unless another is named.

    Raises:
        InvalidInput: a variable that it has not or that has no unit, or nothing that could be judged.
    """
    variables = {variable.name: (place, variable) for place, variable in enumerate(fmu.variables, start=1)}
    outputs = [variable.name for variable in fmu.variables if variable.output]
    listed = f"its outputs are {', '.join(outputs[:LISTED]) or 'none'}{', ...' if len(outputs) > LISTED else ''}"
    clock, *others = targets(points)
    columns = [Column(clock, 0, TIME, "s", 1.0, "FMI")]
    for target in others:
        name = asked.columns.get(target.name, target.name if target.name in outputs else None)
        if name is not None and name not in variables:
            near = " or ".join(map(repr, nearest(name, list(variables)[:COMPARED]))) or "none like it"
            raise InvalidInput(f"it has no variable {name!r}, but {near} among {len(variables)}; {listed}")
        if name is not None:
            columns.append(_column(target, *variables[name], asked))
    if len(columns) == 1:
        raise InvalidInput(f"say which variables an observed point is: --point {points[0]}=X,Y; {listed}")
    check_units_used(columns, asked)
    return columns


def _column(target: Target, place: int, variable: Variable, asked: Request) -> Column:
    column = column_of(target, place, variable.name, "" if bare_unit(variable.unit) == "" else variable.unit, asked)
    if column.unit_from == "assumed":
        unit = f"--unit {target.name}={target.unit}"
        raise InvalidInput(f"{variable.name} has no unit in the model description: say with {unit} what it is in")
    return replace(column, unit_from=column.unit_from.replace("heading", "model description"))
