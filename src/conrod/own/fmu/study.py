"""An FMU judged: run, and its trajectory judged as a table is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from conrod.errors import InvalidInput, nearest, unknown_choice
from conrod.own.fmu.unit import Description, Order, read_fmu, simulate
from conrod.own.tables.columns import LISTED, Column, Request, column_of
from conrod.own.tables.headings import TIME, bare_unit, targets
from conrod.own.tables.reading import MOST_ROWS, Reading, reading_of
from conrod.scenes import Scene
from conrod.studies.execution import isolation

FEWEST = 8  # steps of a run
CVODE_TOLERANCE = 1e-9  # relative; FMPy's own is 1e-5


def run_fmu(
    path: Path, scene: Scene, asked: Request, mode: str | None, steps: int, revolutions: float, timeout: float
) -> Reading:
    """The trajectory of an FMU; it is run in a process of its own.

    Args:
        mode: None for the first that it has.
        steps: per revolution.
        timeout: longest time of the run [s].

    Raises:
        InvalidInput: it or an option cannot be used, or its run does not complete.
    """
    with TemporaryDirectory(prefix="conrod-fmu-") as folder:
        fmu = isolation.confined(read_fmu, path, folder)
        mode = fmu.modes[0] if mode is None else mode
        if mode not in fmu.modes:
            raise unknown_choice("mode in --preset", mode, fmu.modes)
        columns = choose_variables(fmu, tuple(scene.lengths), asked)
        used = [fmu.variables[column.index - 1] for column in columns[1:]]
        unused = tuple(one.name for one in fmu.variables if one.output and one not in used)[:LISTED]
        order = _order(mode, scene, steps, revolutions)
        values = isolation.confined(simulate, path, folder, order, used, timeout=timeout)
    has = "".join(f"; it has {other}, too: --preset {other}" for other in fmu.modes if other != mode)
    form = f"FMI {fmu.version} {order}{f'; {fmu.tool}' if fmu.tool else ''}{has}"
    return reading_of(columns, values, np.arange(1, len(values) + 1), unused, form)


def _order(mode: str, scene: Scene, steps: int, revolutions: float) -> Order:
    """The run of a mode; of an input that makes one pass, that pass."""
    span = scene.kinematics.mechanism.driver.span
    start, stop = (0.0, revolutions * scene.period) if span is None else sorted(angle / scene.speed for angle in span)
    count = round((stop - start) / scene.period * steps)
    if not FEWEST <= count < MOST_ROWS:
        raise InvalidInput(f"--steps-per-rev {steps}: {count} steps in all: {FEWEST} to {MOST_ROWS - 1} are taken")
    return Order(mode, steps, CVODE_TOLERANCE if mode == "model-exchange" else None, start, stop, count)


# -- its variables as columns ------------------------------------------------------------------------------------------
COMPARED = 20_000  # names among which a mistyped one is looked for


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
        if name is None:
            continue
        if name not in variables:
            near = " or ".join(map(repr, nearest(name, list(variables)[:COMPARED]))) or "none like it"
            raise InvalidInput(f"it has no variable {name!r}, but {near} among {len(variables)}; {listed}")
        place, variable = variables[name]
        column = column_of(target, place, name, "" if bare_unit(variable.unit) == "" else variable.unit, asked)
        if column.unit_from == "assumed":
            unit = f"--unit {target.unit}"
            raise InvalidInput(f"{name} has no unit in the model description: say with {unit} what it is in")
        columns.append(replace(column, unit_from=column.unit_from.replace("heading", "model description")))
    if len(columns) == 1:
        said = f"--column {points[0]}.x=VARIABLE"
        raise InvalidInput(f"say which variables are the motion of an observed point: {said}; {listed}")
    return columns
