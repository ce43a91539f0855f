"""A model whose meshes, textures or plugins are not there: what its motion does without is left out, and said."""

from __future__ import annotations

import contextlib
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.errors import InvalidInput, list_names
from conrod.mjcf.loading import check_model_path, load_model
from conrod.mjcf.unit_of_length import convert_to_metres
from conrod.mjcf.unknown_names import XML_ERRORS

MAX_INCLUDES = 200  # files that are included, one in the other or side by side
# Kinds of assets in a file, each with the folder that the compiler is given for it.
ASSET_FOLDERS = {"meshes": "meshdir", "textures": "texturedir", "hfields": "meshdir", "skins": "meshdir"}
ASSET_NOUNS = {"meshes": "mesh", "textures": "texture image", "hfields": "height field", "skins": "skin"}
GEOM, XBODY = int(mujoco.mjtObj.mjOBJ_GEOM), int(mujoco.mjtObj.mjOBJ_XBODY)


@dataclass
class LeftOut:
    """Parts deleted from a model because their files or plugins are missing.

    Attributes:
        files: names of the files that are not there, by kind of asset.
        colliding: number of geoms that could collide.
        heavy: files by the body that has mass of them.
        plugins: names of plugins that this MuJoCo does not have, each with the elements that go with it.
    """

    files: dict[str, list[str]] = field(default_factory=dict)
    colliding: int = 0
    heavy: dict[str, list[str]] = field(default_factory=dict)
    plugins: dict[str, list[str]] = field(default_factory=dict)

    @property
    def words(self) -> Iterator[str]:
        """Yield a sentence for files, for their mass and for plugins."""
        said = []
        for kind, names in self.files.items():
            noun = ASSET_NOUNS[kind]
            count = f"{len(names)} {kind if kind == 'meshes' else noun + 's'}" if len(names) > 1 else f"1 {noun}"
            said.append(f"{count} ({list_names(names, 4)})")
        if said:
            one = sum(map(len, self.files.values())) == 1
            contacts = (
                f", but contacts of {self.colliding} geom{'s' if self.colliding > 1 else ''} are not seen"
                if self.colliding
                else ""
            )
            verb, they = ("is", "it") if one else ("are", "them")
            yield f"{' and '.join(said)} {verb} not there and left out: no motion needs {they}{contacts}"
        for body, names in self.heavy.items():
            yield f"{body} lacks the mass of {list_names(names)}: its motion under forces is another"
        for name, parts in self.plugins.items():
            lost = f", with {list_names(parts)}" if parts else ""
            unknown = f"plugin {name} is not known to MuJoCo {mujoco.__version__}"
            yield f"{unknown} and left out{lost}: what it does is missing"


def load_with_notes(path: Path, unit: float = 1.0) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    """Load a model in metres without its missing assets and plugins; also return notes on them.

    To be called in a process of its own, see `load_model`.

    Args:
        unit: unit of the file's lengths [m].

    Raises:
        InvalidInput: the file cannot be used, or what is missing cannot be left out; says why.
    """
    check_model_path(path)
    notes: tuple[str, ...] = ()
    try:
        model = load_model(path)
    except InvalidInput:
        found = None if path.suffix.lower() == ".mjb" or not path.is_file() else spec_without_missing(path)
        if found is None:
            raise
        spec, left_out = found
        model, notes = _compile_without(path, spec, left_out), tuple(left_out.words)
    convert_to_metres(model, unit)
    return model, notes


def spec_without_missing(path: Path) -> tuple[mujoco.MjSpec, LeftOut] | None:
    """Parse a model without its missing assets and plugins; None if none is missing."""
    left_out = LeftOut()
    with silence_warnings(), contextlib.chdir(path.resolve().parent):
        try:
            spec = mujoco.MjSpec.from_file(path.name)
        except ValueError as error:
            if "plugin" not in str(error):
                return None
            spec = _parse_without_plugins(Path(path.name), str(error), left_out)
        if spec is None:
            return None
        for kind in ASSET_FOLDERS:
            _take_out_missing(spec, kind, left_out)
    return (spec, left_out) if left_out.files or left_out.plugins else None


def _compile_without(path: Path, spec: mujoco.MjSpec, left_out: LeftOut) -> mujoco.MjModel:
    """Compile a model whose missing parts were deleted; raises InvalidInput if it needs them."""
    with silence_warnings(), contextlib.chdir(path.resolve().parent):
        try:
            return spec.compile()
        except ValueError as error:
            raise InvalidInput(_compile_error_words(path, str(error), left_out)) from None


def _compile_error_words(path: Path, error: str, left_out: LeftOut) -> str:
    """Error message for a model that does not compile without its missing parts."""
    if "mass and inertia of moving bodies" in error and left_out.heavy:
        said = "; ".join(f"{list_names(files)} gives {body} its only mass" for body, files in left_out.heavy.items())
        folder = f"beside {path}, or in its meshdir"
        return f"{path}: {said}, and is not there: put it {folder}, or give the body an <inertial>"
    missing = list_names([*(name for names in left_out.files.values() for name in names), *left_out.plugins])
    return f"{path}: MuJoCo cannot load it without {missing}, which are not there: {' '.join(error.split())}"


# -- assets ------------------------------------------------------------------------------------------------------------


def _take_out_missing(spec: mujoco.MjSpec, kind: str, left_out: LeftOut) -> None:
    """Delete a model's assets of a kind whose files are missing, and all references to them."""
    folder = getattr(spec.compiler, ASSET_FOLDERS[kind])
    for asset in list(getattr(spec, kind)):
        files = [*asset.cubefiles, asset.file] if kind == "textures" else [asset.file]
        missing = [file for file in files if file and not _is_there(file, folder)]
        if not missing:
            continue
        left_out.files.setdefault(kind, []).extend(dict.fromkeys(Path(file).name for file in missing))
        name = asset.name or Path(missing[0]).stem
        if kind in ("meshes", "hfields"):
            field_name = "meshname" if kind == "meshes" else "hfieldname"
            for geom in [geom for geom in spec.geoms if getattr(geom, field_name) == name]:
                _take_out_geom(spec, geom, Path(missing[0]).name, left_out)
        for material in spec.materials if kind == "textures" else ():
            for role, texture in enumerate(list(material.textures)):
                if texture == name:
                    material.textures[role] = ""
        spec.delete(asset)


def _is_there(file: str, folder: str) -> bool:
    """True if an asset's file is in one of the places where MuJoCo looks for it."""
    return any(place.is_file() for place in (Path(folder, file), Path(file)))


def _take_out_geom(spec: mujoco.MjSpec, geom: Any, file: str, left_out: LeftOut) -> None:
    """Delete a geom, its pairs and its sensors from a model; record lost contacts and mass."""
    left_out.colliding += bool(geom.contype or geom.conaffinity)
    if _gives_mass(spec, geom):
        left_out.heavy.setdefault(geom.parent.name or "a body", []).append(file)
    for pair in [one for one in spec.pairs if geom.name and geom.name in (one.geomname1, one.geomname2)]:
        spec.delete(pair)
    for sensor in list(spec.sensors):
        ends = ((int(sensor.objtype), sensor.objname), (int(sensor.reftype), sensor.refname))
        if geom.name and (GEOM, geom.name) in ends:
            spec.delete(sensor)
    spec.delete(geom)


def _gives_mass(spec: mujoco.MjSpec, geom: Any) -> bool:
    """True if MuJoCo's compiler infers mass of a movable body from a geom."""
    body = geom.parent
    from_geom = int(spec.compiler.inertiafromgeom)
    inferred = from_geom == int(mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE) or (
        from_geom == int(mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO) and not body.explicitinertial
    )
    low, high = spec.compiler.inertiagrouprange
    weighs = geom.density > 0.0 if np.isnan(geom.mass) else geom.mass > 0.0
    return bool(inferred and weighs and low <= geom.group <= high and _is_moved(body))


def _is_moved(body: Any) -> bool:
    """True if a body, or an ancestor of it, has a joint."""
    while body is not None and body.name != "world":
        if len(body.joints):
            return True
        body = body.parent
    return False


# -- plugins -----------------------------------------------------------------------------------------------------------


def _parse_without_plugins(path: Path, error: str, left_out: LeftOut) -> mujoco.MjSpec | None:
    """Parse a file without the plugins that MuJoCo lacks; None if it does not parse even so."""
    try:
        root = _expand_includes(ET.parse(path).getroot(), path.parent, [path])
    except XML_ERRORS:
        return None
    for _ in range(len(list(root.iter("plugin")))):
        name = next((one for one in _plugin_names(root) if f"plugin {one} not found" in error), None)
        if name is None:
            return None
        left_out.plugins[name] = list(_take_out_plugin(root, name))
        try:
            return mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
        except ValueError as another:
            error = str(another)
    return None


def _expand_includes(element: ET.Element, folder: Path, seen: list[Path]) -> ET.Element:
    """Replace each <include> below an XML element by the included file's elements, as MuJoCo does."""
    for child in list(element):
        if child.tag != "include":
            _expand_includes(child, folder, seen)
            continue
        file = folder / child.get("file", "")
        seen.append(file)
        if len(seen) > MAX_INCLUDES:
            raise ValueError("too many files are included")
        position = list(element).index(child)
        element.remove(child)
        for k, part in enumerate(_expand_includes(ET.parse(file).getroot(), folder, seen)):
            element.insert(position + k, part)
    return element


def _plugin_names(root: ET.Element) -> Iterable[str]:
    return dict.fromkeys(name for one in root.iter("plugin") if (name := one.get("plugin")))


def _take_out_plugin(root: ET.Element, name: str) -> Iterator[str]:
    """Delete a plugin and its instances from an XML tree; name each force or element that is lost."""
    instances = {
        one.get("name")
        for declared in root.iter("plugin")
        if declared.get("plugin") == name
        for one in declared.iter("instance")
    }
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag == "plugin" and (child.get("plugin") == name or child.get("instance") in instances):
                parent.remove(child)
                if parent.tag not in ("extension", "mujoco"):
                    what = f"force on body {parent.get('name', '')}" if parent.tag == "body" else parent.tag
                    yield f"its {what}".strip()
