"""Variables of an FMU as the columns of a table: which of them are the observed points and the crank."""

from __future__ import annotations

import re
from collections.abc import Sequence

from conrod.errors import InvalidInput, named_values, nearest
from conrod.own.fmu.description import Description, Variable
from conrod.own.tables.columns import LISTED, Column, Request, check_units_used, factor_of, unit_of
from conrod.own.tables.headings import AXES, CRANK_ANGLE, TIME, Target, targets

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
    unit, source = unit_of(target, "", variable.unit, asked)
    if source == "assumed":
        what = f"unit {variable.unit!r}, which is not known" if variable.unit else "no unit in the model description"
        raise InvalidInput(f"{variable.name} has {what}: say with --unit {target.name}={target.unit} what it is in")
    scale = factor_of(unit, target, f"variable {variable.name!r}")
    return Column(target, place, variable.name, unit, scale, source.replace("rows", "model description"))
