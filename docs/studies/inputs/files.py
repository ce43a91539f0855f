"""Mechanism files with slips, misprints, FMUs and settings of engines, and what is right of these."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from functools import cache

import numpy as np

from conrod.models.export.fmu import fmu
from conrod.scenes import SCENES
from docs.studies.inputs.edits import replaced, rounded, saw, toml
from docs.studies.inputs.input import Input, healthy, wrong

MECHANISMS, PRINTED = "mechanism files", "printed values, FMUs, settings"
RUN = "validate m.toml --engine mujoco --preset hardened --steps-per-rev 200 --revolutions 1"
WITHIN = "within tolerance"


def _toml(*pairs: tuple[str, str], of: str = "slider-crank") -> dict[str, str | bytes]:
    return {"m.toml": replaced(toml(of), *pairs)}


def mechanisms() -> Iterator[Input]:
    """Mechanism files with slips, and changed as their format allows."""
    kind = MECHANISMS
    short = _toml(('B = ["560 mm", 0], G', 'B = ["100 mm", 0], G'))
    yield wrong(
        kind, "a rod too short for the crank's turn", short, RUN, r"cannot turn fully|lengths do not reach|driver", (2,)
    )
    start = _toml(('speed = "30 rad/s"', 'speed = "30 rad/s"\nstart = 60'))
    yield wrong(kind, "a start of 60, meant in degrees", start, RUN, r"start.*(rad|deg)", (1, 2))
    centre = _toml(('mass = "10 kg"', 'mass = "10 kg"\ncentre_of_gravity = [50, 0]'))
    yield wrong(
        kind, "a centre of gravity 50 m from its link", centre, RUN, r"centre_of_gravity|centre of gravity", (1, 2)
    )
    unit = _toml(('B = ["560 mm", 0], G', 'B = ["560 kg", 0], G'))
    yield wrong(kind, "a length in kilograms", unit, RUN, r"560 kg|length", (2,))
    field = _toml(('guide = "ground.O12"', 'giude = "ground.O12"'))
    yield wrong(kind, "a field that is misspelt", field, RUN, r"giude.*guide|guide.*giude", (2,))
    point = _toml(('"crank.A", "rod.A"', '"crank.A", "rod.Z"'))
    yield wrong(kind, "a pin at a point that there is none of", point, RUN, r"rod\.Z|Z\b", (2,))
    loose = _toml(('[joints.slider-pin]\nkind = "revolute"\nconnects = ["rod.B", "slider"]\n', ""))
    yield wrong(kind, "a pin that is missing", loose, RUN, r"mobility (is )?3|mobility", (2,))
    light = _toml(('mass = "8 kg"', 'mass = "-8 kg"'))
    yield wrong(kind, "a mass below zero", light, RUN, r"mass", (2,))
    metres = _toml(('A = ["300 mm", 0]', "A = [300, 0]"))
    yield wrong(kind, "300 m for 300 mm", metres, RUN, r"cannot|reach|unit|300", (2,))
    still = _toml(('A = "crank.A"', 'A = "crank"'))
    yield wrong(kind, "an observed point that stands still", still, RUN, r"observed\.A.*moves|stand", (2,))

    yield healthy(kind, "as it ships", _toml(), RUN, WITHIN)
    yield healthy(kind, "lengths in inches", _toml(('["300 mm", 0]', '["11.81102 in", 0]')), RUN, WITHIN)
    yield healthy(kind, "another rod", _toml(('B = ["560 mm", 0], G', 'B = ["700 mm", 0], G')), RUN, WITHIN)
    other = toml("slider-crank").replace("crank-pin", "pin-2").replace("bodies.slider", "bodies.Kolben")
    names = {"m.toml": other.replace('"slider"', '"Kolben"')}
    yield healthy(kind, "other names", names, RUN, WITHIN)
    yield healthy(kind, "the other sense", _toml(('speed = "30 rad/s"', 'speed = "-30 rad/s"')), RUN, WITHIN)
    slow = _toml(('speed = "30 rad/s"', 'speed = "5 rpm"'))
    yield healthy(kind, "another speed", slow, RUN, WITHIN)
    weight = _toml(('output = "B"', 'output = "B"\ngravity = [0, "-9.81 m/s^2"]'))
    yield healthy(kind, "weight besides", weight, RUN, WITHIN)
    leaning = _toml(
        ('direction = "0 deg"', 'direction = "20 deg"'), ("rod = { turn = 0 }", 'rod = { turn = "20 deg" }')
    )
    yield healthy(kind, "a slide that leans", leaning, RUN, WITHIN)
    six = {"m.toml": rounded(toml("six-bar"), 6)}
    yield healthy(kind, "a six-bar in six digits", six, RUN.replace("200", "1000"), WITHIN)
    parameters = _toml(
        ('["300 mm", 0]', '["r", 0]'), ("[driver]", '[parameters]\nr = "250 mm"\n\n[driver]')
    )  # fmt: skip
    yield healthy(kind, "a parameter, set anew", parameters, RUN + " --set r=280mm", WITHIN)


# -- printed values, FMUs, settings ------------------------------------------------------------------------------------

HEAD = "scene,quantity,angle_deg,printed,unit\n"
ANGLES = (10, 40, 75, 110, 160, 205, 250, 300)


def _print(factor: float = 1.0, digits: int = 5, unit: str = "mm/s", shift: float = 0.0) -> list[str]:
    """Rows of the saw's velocity as a textbook prints them."""
    scene = SCENES["saw-40rpm"]
    exact = scene.motion(np.radians(np.array(ANGLES) + shift), scene.speed).point("C").velocity[:, 0]
    return [
        f"saw-40rpm,C velocity x,{angle},{1e3 * factor * value:.{digits}g},{unit}"
        for angle, value in zip(ANGLES, exact, strict=True)
    ]


def _printed(rows: list[str]) -> dict[str, str | bytes]:
    return {"print.csv": HEAD + "\n".join(rows) + "\n"}


@cache
def _fmu(**parameters: float) -> bytes:
    scene = SCENES["saw-500rpm"]
    content, _ = fmu("saw-500rpm", scene.with_parameters(**parameters) if parameters else scene)
    return content


def _archive(**files: str) -> bytes:
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return written.getvalue()


def printed() -> Iterator[Input]:
    """Misprints, FMUs and settings that are wrong, and others that are right."""
    kind, audit = PRINTED, "audit print.csv"
    rows = _print()
    # Digits that have changed places in one row.
    place, cells = 3, rows[3].split(",")
    digits = cells[3]
    swapped = [
        *rows[:place],
        ",".join([*cells[:3], digits[:-2] + digits[-1] + digits[-2], cells[4]]),
        *rows[place + 1 :],
    ]
    yield wrong(
        kind, "two digits that changed places", _printed(swapped), audit, rf"at 110 deg: .*should be {digits}", (0,)
    )
    yield wrong(kind, "all ten times too large", _printed(_print(10.0)), audit, r"ten times|10 times", (0,))
    yield wrong(kind, "all of the other sign", _printed(_print(-1.0)), audit, r"sign", (0,))
    lost = [row.replace("C velocity x", "C velocity z") for row in rows]
    yield wrong(kind, "a quantity that there is none of", _printed(lost), audit, r"unknown axis 'z'", (2,))
    unit = [row.replace("mm/s", "mm") for row in rows]
    yield wrong(kind, "a velocity in mm", _printed(unit), audit, r"\bmm\b", (2,))
    run = "check machine.fmu --scene saw-500rpm --tolerance position=1e-4 --steps-per-rev 200"
    yield wrong(kind, "an FMU that is none", {"machine.fmu": b"no archive"}, run, r"FMU|archive|zip", (2,))
    empty = {"machine.fmu": _archive(**{"readme.txt": "empty"})}
    yield wrong(kind, "an FMU without a description", empty, run, r"modelDescription|description", (2,))
    other = {"machine.fmu": _fmu(crank=0.101)}
    yield wrong(kind, "an FMU of another crank", other, run, r"crank", (1,))
    coarse = {"model.xml": replaced(saw(), ('timestep="0.0015"', 'timestep="0.12"'))}
    driven = "check model.xml --drive crank=40rpm --tolerance position=0.05mm"
    yield wrong(kind, "a step that is too long", coarse, driven, r"holds position .* with a step of \d", (1,))
    void = {"model.xml": replaced(saw(), (' tolerance="0"', ""))}
    yield wrong(kind, "a solver that stops before it begins", void, "lint model.xml", r"solver-stops-early", (1,))

    agrees = r"agrees"
    yield healthy(kind, "printed in five digits", _printed(rows), audit, agrees)
    yield healthy(kind, "printed in three digits", _printed(_print(digits=3)), audit, agrees)
    metres = _printed(_print(1e-3, unit="m/s"))
    yield healthy(kind, "printed in m/s", metres, audit, agrees)
    yield healthy(kind, "an FMU of the machine", {"machine.fmu": _fmu()}, run, WITHIN)
    open_ = run.replace("--tolerance position=1e-4 ", "")
    yield healthy(kind, "an FMU, measured", {"machine.fmu": _fmu()}, open_, r"measured, not judged")
    for engine, preset in (("mujoco", "tuned"), ("mujoco", "hardened"), ("pymunk", "tuned")):
        command = f"validate six-bar --engine {engine} --preset {preset} --steps-per-rev 500 --revolutions 1"
        yield healthy(kind, f"six-bar in {engine}, {preset}", {}, command, WITHIN)
    stock = "validate saw-500rpm --engine pymunk --preset stock --steps-per-rev 500 --revolutions 1"
    yield healthy(kind, "an engine as it comes", {}, stock, r"measured, not judged")
    torque = "forces saw-500rpm --engine mujoco --preset hardened --quantity torque --steps-per-rev 500"
    yield healthy(kind, "forces of a hardened run", {}, torque, WITHIN)
