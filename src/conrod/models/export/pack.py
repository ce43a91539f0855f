"""A scene as files for others: its exact trajectory, and a pack as a folder or an archive, whole or not at all."""

from __future__ import annotations

import csv
import io
import json
import shlex
import sys
import zipfile
from collections.abc import Mapping
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.link_rotations import ROTATION_COLUMNS, ROTATION_UNITS, link_rotations, rotating_links
from conrod.exact.motion import Array, Side
from conrod.execution.files import file_to_write, folder_to_write, is_folder, is_special_file
from conrod.execution.writing import Batch, single_file
from conrod.mechanism.mechanism import CamContact, Joint, Mechanism, Prismatic, Rack, Revolute, Rolling
from conrod.report import numbers
from conrod.report.drawing.drawing import mechanism_svg
from conrod.report.folder import UNFINISHED, read_document
from conrod.report.results import parameters_table, scene_description
from conrod.report.table import table
from conrod.report.template import page
from conrod.scenes import SCENES, Scene
from conrod.scenes.described_scene import DescribedScene

PACK_SCHEMA = 1
README, PARAMETERS, MECHANISM, TRAJECTORY = "README.md", "parameters.json", "mechanism.json", "trajectory.csv"
# The file that a mechanism comes from, as it is; the values of its numbers are among the parameters.
MACHINE = "machine.toml"
FIGURES = "figures"
DRAWING = f"{FIGURES}/mechanism.svg"
PAGES = (README, PARAMETERS, MECHANISM, TRAJECTORY)
# Keys of the parameters' file, which show that a folder is a pack.
PACK_KEYS = {"schema", "scene", "kind", "parameters"}
ARCHIVE = ".zip"
FILE_MODE = 0o644 << 16  # readable by all, once unpacked
ARCHIVE_DATE = (1980, 1, 1, 0, 0, 0)  # the earliest that a zip archive can hold
JOINT_KINDS: Mapping[type[Joint], str] = {
    Revolute: "revolute", Prismatic: "prismatic", CamContact: "cam contact", Rolling: "rolling", Rack: "rack",
}  # fmt: skip
# Column suffix, attribute of the motion, SI unit.
TABLE_QUANTITIES = (
    ("", "position", "m"),
    ("v", "velocity", "m/s"),
    ("a", "acceleration", "m/s^2"),
    ("j", "jerk", "m/s^3"),
)

PASS_END_ROUNDING = 1e-12  # of a pass's duration, by which rounding may put its last sample beyond its end


def pack_files(
    name: str, scene: Scene, samples: int, revolutions: int, machine: bytes | None = None
) -> dict[str, str | bytes]:
    """Return the contents of all files of a pack by name, the README last.

    Args:
        name: name of the scene.
        samples: samples of the trajectory in a revolution.
        revolutions: revolutions of the trajectory; ignored for an input that makes one pass.
        machine: the mechanism file of the scene; None for a scene in closed form.
    """
    return {
        **({} if machine is None else {MACHINE: machine}),
        PARAMETERS: _json_text(parameters_document(name, scene)),
        MECHANISM: _json_text(mechanism_document(scene.mechanism())),
        TRAJECTORY: as_csv(exact_columns(scene, samples, revolutions)),
        DRAWING: mechanism_svg(scene),
        README: _readme(name, scene, samples),
    }


def _readme(name: str, scene: Scene, samples: int) -> str:
    """Render the page that states the task, the table to hand in, and the figure that counts."""
    mechanism = scene.mechanism()
    lengths = [(point, numbers.quantity(1e3 * length, 9)) for point, length in scene.lengths.items()]
    return page(
        "pack", sys.modules[__name__], name=name, scene=scene, mechanism=mechanism,
        description=scene_description(scene), samples=samples,
        drive=_drive_words(scene), one_pass=mechanism.driver.span is not None, command=_command(name, scene),
        sense="counter-clockwise" if mechanism.driver.sense * scene.speed > 0 else "clockwise",
        lengths=table(("point", "L [mm]"), lengths), parameters=parameters_table(scene),
    ).text  # fmt: skip


def _drive_words(scene: Scene) -> str:
    """Say how the crank is driven: its angles and times."""
    span = scene.kinematics.mechanism.driver.span
    if span is None:
        turn = f"{scene.period:.15g} s each"
        return f"from crank angle 0 at time 0, in motion from the start, over two revolutions of {turn}"
    first, last = span if scene.speed > 0.0 else span[::-1]
    return (
        f"in motion from the start, in one pass from crank angle {first!r} rad at time {first / scene.speed:.15g} s to "
        f"{last!r} rad at {last / scene.speed:.15g} s, with crank angle 0, and the start poses, at time 0: the input "
        "cannot turn fully"
    )


def _command(name: str, scene: Scene) -> str:
    """Return the command that judges a table of the scene, with its changed parameters."""
    usual = (DescribedScene(scene.document) if isinstance(scene, DescribedScene) else SCENES[name]).parameters
    changed = [f"--set {shlex.quote(f'{p}={value!r}')}" for p, value in scene.parameters.items() if value != usual[p]]
    machine = name if scene.closed_form else MACHINE
    return " ".join(["conrod check YOUR.csv --scene", machine, *changed])


def zip_archive(files: Mapping[str, str | bytes]) -> bytes:
    """Zip files into one archive; the same files give the same bytes."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, ARCHIVE_DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = FILE_MODE
            archive.writestr(entry, content)
    return stream.getvalue()


def parameters_document(name: str, scene: Scene) -> dict[str, Any]:
    """Return all parameters in SI and full precision as plain values."""
    facts = scene.parameter_facts()
    return {
        "schema": PACK_SCHEMA,
        "conrod": version("conrod"),
        "scene": name,
        "kind": scene.kind,
        "title": scene.title,
        "source": scene.source,
        "frame": scene.frame,
        "parameters": {
            parameter: {"value": value, "unit": facts[parameter].unit or "1", "meaning": facts[parameter].meaning}
            for parameter, value in scene.parameters.items()
        },
        **({} if scene.closed_form else {"machine": MACHINE}),
        "period": {"value": scene.period, "unit": "s"},
        "lengths": {point: {"value": length, "unit": "m"} for point, length in scene.lengths.items()},
    }


def mechanism_document(mechanism: Mechanism) -> dict[str, Any]:
    """Return bodies, joints, drive and start poses as plain values in SI."""
    return {
        "schema": PACK_SCHEMA,
        "units": "m, kg, s, rad; kg m² about the centre of gravity",
        "bodies": [asdict(body) | {"start_pose": list(mechanism.poses[body.name])} for body in mechanism.bodies],
        "joints": [{"kind": JOINT_KINDS[type(joint)]} | asdict(joint) for joint in mechanism.joints],
        "driver": asdict(mechanism.driver),
        "observed": [asdict(point) for point in mechanism.observed],
        "gravity": list(mechanism.gravity),
        "forces": [asdict(force) for force in mechanism.forces],
        "mobility": mechanism.mobility,
    }


def _json_text(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


# -- on the disk -----------------------------------------------------------------------------------------------------


def pack_to_write(text: str | None) -> Path:
    """Return the folder or archive that a user names, if it is free or an earlier pack.

    Raises:
        InvalidInput: no place is named, or it cannot be written or holds other files.
    """
    if text is None:
        raise InvalidInput("--format pack is a folder or an archive: name it with -o DIR or -o FILE.zip")
    if text.lower().endswith(ARCHIVE):
        return file_to_write(text, "-o")
    folder = folder_to_write(text, "-o")
    try:
        is_own = read_document(folder / PARAMETERS).keys() >= PACK_KEYS
    except (OSError, ValueError, AttributeError):
        is_own = False
    if (folder / FIGURES).is_symlink() or ((folder / FIGURES).exists() and not is_folder(folder / FIGURES)):
        raise InvalidInput(f"cannot write into {folder}: {FIGURES} in it is not a folder")
    for name in (*PAGES, MACHINE, DRAWING):
        if is_special_file(folder / name):
            raise InvalidInput(f"cannot write into {folder}: {name} in it is not a regular file")
        if not is_own and (folder / name).exists():
            raise InvalidInput(f"cannot write into {folder}: it holds a {name} that is not of a pack")
    return folder


def pack_batch(files: Mapping[str, str | bytes], place: Path) -> Batch:
    """Return the files to write: all in the folder, or one archive."""
    if place.name.lower().endswith(ARCHIVE):
        folder = place.name[: -len(ARCHIVE)]
        return single_file(place, zip_archive({f"{folder}/{name}": content for name, content in files.items()}))
    meanwhile = _json_text({**json.loads(files[PARAMETERS]), UNFINISHED: True})
    return Batch(place, files, meanwhile={PARAMETERS: meanwhile})


# -- the trajectory ---------------------------------------------------------------------------------------------------


def exact_columns(scene: Scene, samples: int, revolutions: float) -> dict[str, tuple[str, Array]]:
    """Return the columns of the exact trajectory, name -> (unit, values (T,)); links' rotations come last.

    Args:
        samples: instants in a revolution, equally spaced; the last instant of the run is included.
        revolutions: turns of the crank from angle 0; an input that makes one pass makes that, from its start, whose
            time is before that of crank angle 0, which is 0 everywhere.
    """
    times, angle = _instants(scene, samples, revolutions)
    makes_a_pass = scene.mechanism().driver.span is not None
    motion = scene.motion(angle, scene.speed) if makes_a_pass else scene.reference(times)
    columns: dict[str, tuple[str, Array]] = {"time": ("s", times), "crank_angle": ("rad", angle)}
    for name, point in motion.points.items():
        for prefix, quantity, unit in TABLE_QUANTITIES:
            values: Array = getattr(point, quantity)
            for k, axis in enumerate("xy"):
                columns[f"{name}.{prefix}{axis}"] = (unit, values[:, k])
    return columns | _rotation_columns(scene, angle, "right" if makes_a_pass or scene.speed > 0.0 else "left")


def _rotation_columns(scene: Scene, angle: Array, side: Side) -> dict[str, tuple[str, Array]]:
    """Return the columns of the links that rotate, as in `exact_columns`, at crank angles (T,) [rad]."""
    kinematics, names = scene.kinematics, rotating_links(scene.kinematics)
    found = link_rotations(kinematics, angle, scene.speed, side=side)
    return {
        f"{letter}_{name}": (ROTATION_UNITS[quantity], values[:, kinematics.mechanism.body_index[name]])
        for name in names
        for (quantity, letter), values in zip(ROTATION_COLUMNS.items(), found, strict=True)
    }


def _instants(scene: Scene, samples: int, revolutions: float) -> tuple[Array, Array]:
    """Return times [s] and crank angles [rad], each (T,)."""
    step, span = scene.period / samples, scene.mechanism().driver.span
    if span is None:
        times = np.asarray(np.arange(round(samples * revolutions) + 1) * step, dtype=float)
        return times, scene.speed * times
    duration = (span[1] - span[0]) / abs(scene.speed)
    begin = (span[0] if scene.speed > 0.0 else span[1]) / scene.speed
    times = begin + np.asarray(np.arange(int(duration / step * (1.0 + PASS_END_ROUNDING)) + 1) * step, dtype=float)
    return times, np.clip(scene.speed * times, *span)


def as_csv(columns: dict[str, tuple[str, Array]]) -> str:
    """Return columns as CSV with units in the headings and numbers in full precision."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(f"{name} [{unit}]" for name, (unit, _) in columns.items())
    writer.writerows(zip(*(map(repr, values.tolist()) for _, values in columns.values()), strict=True))
    return stream.getvalue()
