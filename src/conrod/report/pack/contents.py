"""A pack: its files, and the folder or the archive that they are written to, whole or not at all."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Mapping
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput
from conrod.mechanism.mechanism import Mechanism
from conrod.report.drawing.drawing import mechanism_svg
from conrod.report.folder import document_in
from conrod.report.pack.export import as_csv, as_npz, exact_columns
from conrod.report.pack.readme import joint_kind, readme, worth_meeting
from conrod.scenes import Scene
from conrod.studies.frame.files import file_to_write, folder_to_write, is_folder, is_no_file
from conrod.studies.frame.writing import Batch, single

SCHEMA = 1
README, PARAMETERS, MECHANISM, TOLERANCES = "README.md", "parameters.json", "mechanism.json", "tolerances.json"
# The file that a mechanism comes from, as it is; the values of its numbers are among the parameters.
MACHINE = "machine.toml"
TRAJECTORY_CSV, TRAJECTORY_NPZ = "trajectory.csv", "trajectory.npz"
FIGURES = "figures"
DRAWING = f"{FIGURES}/mechanism.svg"
PAGES = (README, PARAMETERS, MECHANISM, TOLERANCES, TRAJECTORY_CSV, TRAJECTORY_NPZ)
# Of the parameters' file, by which a pack is known.
KEYS = {"schema", "scene", "kind", "parameters"}
ARCHIVE = ".zip"
READABLE = 0o644 << 16  # by all, once unpacked
LONG_AGO = (1980, 1, 1, 0, 0, 0)  # the earliest that a zip archive can say


def pack_files(
    name: str, scene: Scene, samples: int, revolutions: int, machine: bytes | None = None
) -> dict[str, str | bytes]:
    """Content of all files of a pack by their names, the README last.

    Args:
        name: of the scene.
        samples: of the trajectory, a revolution.
        revolutions: of the trajectory; an input that makes one pass makes that.
        machine: the mechanism file that the scene comes from; None of a scene in closed form.
    """
    columns = exact_columns(scene, samples, revolutions)
    tolerances = worth_meeting(scene)
    return {
        **({} if machine is None else {MACHINE: machine}),
        PARAMETERS: _json(parameters_document(name, scene)),
        MECHANISM: _json(mechanism_document(scene.mechanism())),
        TOLERANCES: _json({"schema": SCHEMA, "tolerances": [asdict(t) for t in tolerances]}),
        TRAJECTORY_CSV: as_csv(columns),
        TRAJECTORY_NPZ: as_npz(columns),
        DRAWING: mechanism_svg(scene),
        README: readme(name, scene, tolerances, samples, revolutions, list(columns)),
    }


def zipped(files: Mapping[str, str | bytes]) -> bytes:
    """The files in one archive; the same files give the same bytes."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, LONG_AGO)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = READABLE
            archive.writestr(entry, content)
    return stream.getvalue()


def parameters_document(name: str, scene: Scene) -> dict[str, Any]:
    """All parameters, SI, in full precision."""
    facts = scene.parameter_facts()
    return {
        "schema": SCHEMA,
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
    """Bodies, joints, drive and start poses as plain values, SI."""
    return {
        "schema": SCHEMA,
        "units": "m, kg, s, rad; kg m² about the centre of gravity",
        "bodies": [asdict(body) | {"start_pose": list(mechanism.poses[body.name])} for body in mechanism.bodies],
        "joints": [{"kind": joint_kind(joint)} | asdict(joint) for joint in mechanism.joints],
        "driver": asdict(mechanism.driver),
        "observed": [asdict(point) for point in mechanism.observed],
        "gravity": list(mechanism.gravity),
        "forces": [asdict(force) for force in mechanism.forces],
        "mobility": mechanism.mobility,
    }


def _json(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


# -- on the disk -----------------------------------------------------------------------------------------------------


def pack_to_write(text: str | None) -> Path:
    """The folder or archive that a user names, refused where anything but an earlier pack would be replaced.

    Raises:
        InvalidInput: none is named, or it cannot be written.
    """
    if text is None:
        raise InvalidInput("--format pack is a folder or an archive: name it with -o DIR or -o FILE.zip")
    if text.lower().endswith(ARCHIVE):
        return file_to_write(text, "-o")
    folder = folder_to_write(text, "-o")
    try:
        is_own = document_in(folder / PARAMETERS).keys() >= KEYS
    except (OSError, ValueError, AttributeError):
        is_own = False
    if (folder / FIGURES).is_symlink() or ((folder / FIGURES).exists() and not is_folder(folder / FIGURES)):
        raise InvalidInput(f"cannot write into {folder}: {FIGURES} in it is not a folder")
    for name in (*PAGES, MACHINE, DRAWING):
        if is_no_file(folder / name):
            raise InvalidInput(f"cannot write into {folder}: {name} in it is not a regular file")
        if not is_own and (folder / name).exists():
            raise InvalidInput(f"cannot write into {folder}: it holds a {name} that is not of a pack")
    return folder


def pack_batch(files: Mapping[str, str | bytes], place: Path) -> Batch:
    """All files in the folder, or in one archive."""
    if place.name.lower().endswith(ARCHIVE):
        folder = place.name[: -len(ARCHIVE)]
        return single(place, zipped({f"{folder}/{name}": content for name, content in files.items()}))
    return Batch(place, files)
