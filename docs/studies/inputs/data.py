"""Tables with slips in their columns and from sensors that are faulty, and tables that are right."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from conrod.exact.motion import Array
from conrod.scenes import SCENES
from docs.studies.inputs.edits import Columns, csv, renamed, saw_table
from docs.studies.inputs.input import Input, healthy, wrong

COLUMNS, SENSORS = "columns, units and clocks of tables", "sensors"
ASKED = "check run.csv --scene saw-40rpm --tolerance position=1e-4"
OPEN = "check run.csv --scene saw-40rpm"
WITHIN, MEASURED = r"within tolerance", r"measured, not judged"
SCENE = SCENES["saw-40rpm"]
PERIOD = SCENE.period


def _file(columns: Columns, **how: object) -> dict[str, str | bytes]:
    return {"run.csv": csv(columns, **how)}  # type: ignore[arg-type]


def _times(columns: Columns, factor: float, *letters: str) -> Columns:
    """Columns of points whose names end so, times a factor."""
    return {
        name: values * (factor if name.endswith(letters) and "." in name else 1.0) for name, values in columns.items()
    }


def columns() -> Iterator[Input]:
    """Tables with slips of a tool, and tables in many forms."""
    kind, table = COLUMNS, saw_table()
    yield wrong(
        kind,
        "mm in columns of m",
        _file(_times(table, 1e3, "x", "y")),
        ASKED,
        r"likely cause.*1000 times|mm taken for m",
    )
    degrees = table | {"crank_angle": np.degrees(table["crank_angle"])}
    yield wrong(kind, "degrees in a column of radians", _file(degrees), ASKED, r"degrees")
    swapped = table | {f"{p}.{a}": table[f"{p}.{b}"] for p in "CM" for a, b in ("xy", "yx")}
    yield wrong(kind, "x and y swapped", _file(swapped), ASKED, r"x and y are swapped")
    late = table | {"time": table["time"] + 0.005}
    yield wrong(
        kind, "a clock that is 5 ms late", _file(late), ASKED, r"likely cause.*(5 ms|0\.005 s|late|instant|offset)"
    )
    moving = saw_table("position", "velocity")
    early = saw_table("position", "velocity", rows=360, turns=2.0)
    stamped = moving | {n: early[n][2 * np.arange(181) + 1] for n in moving if ".v" in n}
    both = ASKED + ",velocity=1e-4"
    yield wrong(kind, "velocities of half a step later", _file(stamped), both, r"velocit.*(stamp|step|instant)")
    backwards = saw_table(scene=SCENE.with_parameters(speed=-SCENE.speed))
    yield wrong(kind, "a crank that turns the other way", _file(backwards), ASKED, r"opposite sense")
    rows = csv(table).splitlines()
    rows[40] = rows[40].replace(rows[40].split(",")[2], "n/a")
    yield wrong(kind, "a cell that is no number", {"run.csv": "\n".join(rows)}, ASKED, r"row 4[01]|n/a", (2,))
    order = csv(table).splitlines()
    order[50], order[51] = order[51], order[50]
    yield wrong(kind, "rows out of order", {"run.csv": "\n".join(order)}, ASKED, r"order|row 5", (2,))
    clockless = {name: values for name, values in table.items() if name != "time"}
    yield wrong(kind, "no column of time", _file(clockless), ASKED, r"time", (2,))
    faster = saw_table(scene=SCENE.with_parameters(speed=1.025 * SCENE.speed))
    yield wrong(kind, "41 rpm for 40", _file(faster), ASKED, r"speed|rpm|faster", (1,))

    yield healthy(kind, "as conrod writes it", _file(table), ASKED, WITHIN)
    in_mm = renamed(_times(table, 1e3, "x", "y"), **{f"{p}_{a}": f"{p}.{a} [mm]" for p in "CM" for a in "xy"})
    yield healthy(kind, "mm, said in the headings", _file(in_mm), ASKED, WITHIN)
    bare = {"run.csv": csv(_times(degrees, 1e3, "x", "y"))}, ASKED + " --unit mm --unit deg"
    yield healthy(kind, "mm and deg, said by --unit", *bare, WITHIN)
    yield healthy(kind, "decimal commas", _file(table, separator=";", decimal=","), ASKED, WITHIN)
    yield healthy(kind, "blanks between numbers", _file(table, separator=" "), ASKED, WITHIN)
    six = "check run.csv --scene saw-40rpm --tolerance position=1e-5"
    yield healthy(kind, "six digits", _file(table, digits=6), six, WITHIN)
    other = renamed(table, C_x="px", C_y="py", time="t")
    named = ASKED + " --column C.x=px --column C.y=py"
    yield healthy(kind, "columns by other names", _file(other), named, WITHIN)
    shifted = table | {"time": table["time"] + 0.3}
    yield healthy(kind, "an unknown start, estimated", _file(shifted), ASKED + " --estimate time", WITHIN)
    one = {name: table[name] for name in ("time", "C.x", "M.x", "M.y")}
    yield healthy(kind, "without the crank's angle", _file(one), ASKED, WITHIN)
    yield healthy(kind, "without a tolerance", _file(table), OPEN, MEASURED)


def _noise(table: Columns, size: float) -> Columns:
    """Noise on all positions, as a sensor leaves it."""
    drawn = np.random.default_rng(7)
    return {n: v + (drawn.normal(0.0, size, len(v)) if n[-2:] in (".x", ".y") else 0.0) for n, v in table.items()}


def sensors() -> Iterator[Input]:
    """Tables of faulty sensors, and of sensors that are as good as sensors are."""
    kind, table = SENSORS, saw_table()
    moving = saw_table("position", "velocity")
    dead = moving | {"C.vx": 0.0 * moving["C.vx"]}
    yield wrong(
        kind,
        "a dead sensor of velocity",
        _file(dead),
        ASKED + ",velocity=1e-3",
        r"C\.vx.*(dead|0|move|constant|still)|dead",
    )
    stuck = table | {"M.x": np.where(np.arange(181) > 90, table["M.x"][90], table["M.x"])}
    yield wrong(
        kind,
        "a sensor that sticks half way",
        _file(stuck),
        ASKED,
        r"M\.x.*(stick|stuck|frozen|constant|stands|dead)",
        (1,),
    )
    zero = table | {"crank_angle": table["crank_angle"] + np.radians(3.0)}
    yield wrong(
        kind, "an encoder's zero off by 3 deg", _file(zero), ASKED, r"crank angle is 0 where the scene's is -3 deg"
    )
    moved = {n: v + (0.01 if n.endswith(".x") else 0.0) for n, v in table.items()}
    yield wrong(kind, "an origin 10 mm off", _file(moved), ASKED, r"origin|frame")
    turned = dict(table)
    for point in "CM":
        turned |= _turned(table, point, np.radians(2.0))
    yield wrong(kind, "axes turned by 2 deg", _file(turned), ASKED, r"axes|frame|turned")
    full = table | {"C.x": np.clip(table["C.x"], -0.15, 0.1)}
    yield wrong(
        kind, "a sensor out of its range", _file(full), ASKED, r"C\.x.*(range|clip|cut off|saturat|limit)", (1,)
    )
    out = table | {"M.y": table["M.y"] + np.where(np.arange(181) == 77, 0.05, 0.0)}
    yield wrong(kind, "one row that is 50 mm off", _file(out), ASKED, r"1 of 181 rows .*M\.y by 50 mm|outlier", (1,))
    yield wrong(
        kind, "a gain 1 % too large", _file(_times(table, 1.01, "x", "y")), ASKED, r"1\.01|gain|scale|factor|size", (1,)
    )
    drift = {n: v + (1e-3 * table["time"] if n.endswith(".x") else 0.0) for n, v in table.items()}
    yield wrong(kind, "a drift of 1 mm a second", _file(drift), ASKED, r"drift", (1,))
    felt = saw_table("position", "acceleration")
    felt = felt | {n: v + 9.81 for n, v in felt.items() if n.endswith(".ay")}
    yield wrong(
        kind, "gravity left in an acceleration", _file(felt), ASKED + ",acceleration=1e-3", r"gravity|9\.81|free fall"
    )

    for size in (1e-5, 1e-4):
        file = _file(_noise(table, size))
        yield healthy(kind, f"noise of {1e3 * size:g} mm, measured", file, OPEN, MEASURED)
        loose = f"check run.csv --scene saw-40rpm --tolerance position={50 * size:g}"
        yield healthy(kind, f"noise of {1e3 * size:g} mm, within its tolerance", file, loose, WITHIN)
    encoder = {name: table[name] for name in ("time", "crank_angle")}
    alone = "check run.csv --scene saw-40rpm --tolerance phase=1e-6"
    yield healthy(kind, "an encoder alone", _file(encoder), alone, WITHIN)
    steps = 2.0 * np.pi / 4096.0
    ticks = encoder | {"crank_angle": np.floor(table["crank_angle"] / steps) * steps}
    tick = "check run.csv --scene saw-40rpm --tolerance phase=0.1deg"
    yield healthy(kind, "an encoder of 4096 ticks", _file(ticks), tick, WITHIN)
    yield healthy(kind, "one point of two", _file({n: table[n] for n in ("time", "M.x", "M.y")}), ASKED, WITHIN)
    spare = table | {"temperature": 20.0 + 0.1 * table["time"]}
    yield healthy(kind, "a thermometer more", _file(spare), ASKED, WITHIN)
    all_three = _file(saw_table("position", "velocity", "acceleration"))
    yield healthy(kind, "all that moves", all_three, ASKED + ",velocity=1e-4,acceleration=1e-4", WITHIN)
    coarse = _file(saw_table(rows=12, turns=3.0))
    yield healthy(kind, "twelve rows a turn", coarse, ASKED, WITHIN)


def _turned(table: Columns, point: str, angle: float) -> dict[str, Array]:
    x, y = table[f"{point}.x"], table[f"{point}.y"]
    cosine, sine = np.cos(angle), np.sin(angle)
    return {f"{point}.x": cosine * x - sine * y, f"{point}.y": sine * x + cosine * y}
