"""Scenes, engines, presets and plans from the names and values that a user or a program gives."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from conrod.engines import Engine, engine_named, engine_names, installed_extras, loadable_engines, presets_of
from conrod.errors import ConrodWarning, InvalidInput, named_values, unknown_choice
from conrod.execution.families import MAX_MEMBERS, Value, member_arguments, members_of, split_values
from conrod.execution.result import Plan
from conrod.execution.tolerances import ALL_TOLERANCE_NAMES, check_tolerance
from conrod.mechanism.units import check_count
from conrod.scenes import (
    CATALOGUE,
    SCENES,
    SPATIAL,
    Scene,
    catalogue_names,
    catalogue_text,
    machines_in_space,
    scene_named,
)

MECHANISM_FILE = ".toml"
MODEL_FILES = (".xml", ".mjcf", ".mjb", ".urdf")
ALL_ENGINES = "all"
STEPS_RANGE = (2, 10_000_000)
REVOLUTIONS_RANGE = (1, 1_000_000)
# For studies that keep all samples (forces, own models, tables, ablate): at about 3 kB a sample this is 1.5 GB.
MAX_KEPT_SAMPLES = 500_000
# For runs that are compared while they run: some 40 us a step with the refinement path, so most would time out.
MAX_STREAMED_SAMPLES = 20_000_000


OneScene: TypeAlias = str | Path | Scene | tuple[str, Scene]  # of a pair the first is what it is called
Scenes: TypeAlias = OneScene | Sequence[OneScene] | Mapping[str, Scene]
Engines: TypeAlias = str | Sequence[str | Engine[Any]] | None


def scenes_by_name(scenes: Scenes) -> dict[str, Scene]:
    """Scenes by name: names, mechanism files or objects; the four with a closed form where none is given.

    Raises:
        InvalidInput: a scene or file does not exist, or two scenes have one name.
    """
    if isinstance(scenes, Mapping):
        return dict(scenes)
    given: list[OneScene] = [scenes] if is_single_scene(scenes) else list(scenes)  # type: ignore[list-item, arg-type] # told apart
    names = [str(one) for one in given if isinstance(one, str | Path)]
    found = select_scenes(names, ()) if names or not given else {}
    for one in given:
        if isinstance(one, str | Path):
            continue
        name, machine = one if isinstance(one, tuple) else (one.kind, one)
        if name in found:
            raise InvalidInput(f"two scenes are called {name!r}: give them as a mapping, by names of your own")
        found[name] = machine
    return found


def is_single_scene(scenes: object) -> bool:
    """True for one scene, False for a sequence of scenes."""
    pair = isinstance(scenes, tuple) and len(scenes) == 2 and isinstance(scenes[1], Scene)
    return isinstance(scenes, str | Path | Scene) or pair


def scene_by_name(scene: OneScene) -> tuple[str, Scene]:
    """Find one scene, and return its name and the scene."""
    if isinstance(scene, tuple):
        return scene
    return select_scene(scene if isinstance(scene, Scene) else str(scene), ())


def choose_engines(engines: Engines) -> list[Engine[Any]]:
    """Find engines by name or object; "all" gives every installed engine, None the default engines.

    Raises:
        InvalidInput: an engine is unknown or cannot be loaded.
    """
    given = [engines] if isinstance(engines, str) else list(engines or ())
    objects = [one for one in given if isinstance(one, Engine)]
    names = [one for one in given if isinstance(one, str)]
    if objects and not names:
        return objects
    return [*objects, *select_engines(names, left_out=_warn_left_out)]


def engine_names_given(engines: Engines) -> tuple[str, ...]:
    """Names of the engines that the caller gave."""
    given = [engines] if isinstance(engines, str) else list(engines or ())
    return tuple(one if isinstance(one, str) else one.name for one in given)


def _warn_left_out(reason: str) -> None:
    warnings.warn(f"left out: {reason}", ConrodWarning, stacklevel=4)


def select_scenes(names: Sequence[str], assignments: Sequence[str]) -> dict[str, Scene]:
    """Find scenes by name or file, with parameter values assigned; closed-form scenes if none is named.

    The word `catalogue` stands for all machines of the catalogue. An assignment `name=value` applies to every selected
    scene that has the parameter; `name=value,value` makes a family of it, with a member for each value.

    Raises:
        InvalidInput: unknown scene, parameter or unit, or a value out of range.
    """
    if spatial := next((name for name in machines_in_space(names) if name != SPATIAL), None):
        takes = f"`conrod validate {spatial}` and `conrod export {spatial} --format mjcf`"
        raise InvalidInput(f"{spatial} is a machine in space: {takes} take it")
    return _assign_parameters(_find_scenes(names or list(SCENES)), assignments)


def _assign_parameters(scenes: Mapping[str, Scene], assignments: Sequence[str]) -> dict[str, Scene]:
    if not assignments:
        return dict(scenes)
    values, found = assigned_values(scenes, assignments), dict[str, Scene]()
    for name, scene in scenes.items():
        found |= members_of(name, scene, values)
    if len(found) > MAX_MEMBERS:
        raise InvalidInput(f"{len(found)} machines are too many: there may be {MAX_MEMBERS}")
    return found


def assigned_values(scenes: Mapping[str, Scene], assignments: Sequence[str]) -> dict[str, Value]:
    """Texts of the values that assignments give, by parameter; raises InvalidInput as `select_scenes`."""
    known = {name for scene in scenes.values() for name in scene.parameter_facts()}
    texts = named_values(assignments, "--set", kind="parameter", known=known)
    return {name: split_values(name, text) for name, text in texts.items()}


def select_scene(name: str | Scene, assignments: Sequence[str]) -> tuple[str, Scene]:
    """Find one scene as `select_scenes` does; return its name (the kind for a scene object) and the scene."""
    if name == CATALOGUE:
        raise InvalidInput(f"{name!r} stands for many machines: name one of them; `conrod show` lists them")
    found = (
        _assign_parameters({name.kind: name}, assignments)
        if isinstance(name, Scene)
        else select_scenes([name], assignments)
    )
    if len(found) != 1:
        refuse_lists(assignments)
    ((known_as, scene),) = found.items()
    return known_as, scene


def refuse_lists(assignments: Sequence[str]) -> None:
    """Refuse assignments of several values where one machine is taken; raises InvalidInput."""
    if listed := next((text for text in assignments if "," in text), None):
        raise InvalidInput(
            f"--set {listed}: one machine is taken here, not a family: give one value; `conrod validate` and "
            "`conrod sweep` take a list"
        )


def scene(name: str | Path, **parameters: float | str) -> Scene:
    """Return a shipped scene by name, or a scene from a mechanism file, with parameter values assigned.

    Args:
        parameters: numbers in SI, or text with a unit: `scene("saw-40rpm", crank="80 mm")`.

    Raises:
        InvalidInput: the scene, file or parameter does not exist, or a value is out of range.
    """
    return select_scene(str(name), [f"{one}={value}" for one, value in parameters.items()])[1]


def family(scene: OneScene, **parameters: float | str | Sequence[float | str]) -> dict[str, Scene]:
    """Return the machines of a family by name: a scene with each combination of its parameters' values.

    Args:
        scene: a shipped scene by name, a mechanism file, or a scene; of a pair the first is what it is called.
        parameters: one value for all machines, or several: numbers in SI, or text with a unit.

    `family("saw-40rpm", crank=["80 mm", "90 mm"])` has `saw-40rpm-crank=80mm` and `saw-40rpm-crank=90mm`. It is what
    `conrod.validate` and other studies take as scenes; families are put together with `|`.

    Raises:
        InvalidInput: there is no such scene, file or parameter, a value is out of range or given twice, there are too
            many machines, or one of them cannot be assembled.
    """
    name, machine = scene_by_name(scene)
    for one in parameters:
        if one not in machine.parameter_facts():
            raise unknown_choice("parameter", one, machine.parameter_facts())
    values: dict[str, Value] = {
        one: split_values(one, value) if isinstance(value, str) else _texts_of(value)
        for one, value in parameters.items()
    }
    if empty := next((one for one, value in values.items() if not value), None):
        raise InvalidInput(f"{empty}: give at least one value")
    return members_of(name, machine, values)


def _texts_of(value: float | Iterable[float | str]) -> Value:
    """Text of a parameter's only value, or texts of several."""
    return tuple(map(str, value)) if isinstance(value, Iterable) else str(value)


def scene_label(scene: str | Scene) -> str:
    """Name of a machine: the text that the user typed, or the kind of a scene object."""
    return scene if isinstance(scene, str) else scene.kind


def arguments_of_files(names: Sequence[str]) -> dict[str, str]:
    """Arguments typed for scenes from files, by the scene names that `select_scenes` gives them.

    Whoever makes a report again has to name the file, not the machine in it.
    """
    from conrod.mechanism.files import read_tables

    return {read_tables(Path(given))["name"]: given for given in names if is_mechanism_file(given)}


def arguments_of_members(names: Sequence[str], assignments: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Arguments that select each machine alone, by the names of `select_scenes`; empty without a family."""
    scenes = _find_scenes(names or list(SCENES))
    values = assigned_values(scenes, assignments)
    if all(isinstance(one, str) for one in values.values()):
        return {}
    return member_arguments(arguments_of_files(names), scenes, values)


def is_mechanism_file(given: str) -> bool:
    """True if the user's argument is a mechanism file, False for a scene's name."""
    return given.lower().endswith(MECHANISM_FILE)


def mechanism_file_bytes(given: str) -> bytes | None:
    """Content of a scene's mechanism file; None for a closed-form scene."""
    if given in SCENES:
        return None
    return Path(given).read_bytes() if is_mechanism_file(given) else catalogue_text(given).encode()


def _shipped_scene(name: str) -> Scene:
    """Find a shipped scene; of a folder's name say that machines are no folders."""
    try:
        return scene_named(name)
    except InvalidInput:
        if name and Path(name).is_dir():
            raise InvalidInput(
                f"{name}: it is a folder; a machine goes by its name, which `conrod show` lists, or is a file that "
                f"ends in {MECHANISM_FILE}"
            ) from None
        raise


def _find_scenes(names: Sequence[str]) -> dict[str, Scene]:
    """Find scenes by name or file; a scene from a file has the name written in the file.

    A file may have the name of a machine of the catalogue, as a changed copy of it has, but not beside that machine.
    """
    scenes: dict[str, Scene] = {}
    files: dict[str, str] = {}
    for given in (one for name in names for one in (catalogue_names() if name == CATALOGUE else (name,))):
        if Path(given).suffix and not is_mechanism_file(given):
            own = given.lower().endswith(MODEL_FILES)
            judged = f"; a model of your own is judged by: conrod check {given} --drive JOINT=LAW" if own else ""
            raise InvalidInput(
                f"{given}: a machine goes by its name, or is a file that ends in {MECHANISM_FILE}{judged}"
            )
        scene = _read_scene_file(given) if is_mechanism_file(given) else _shipped_scene(given)
        name = scene.kind if is_mechanism_file(given) else given
        if name in files or (is_mechanism_file(given) and (name in SCENES or name in scenes)):
            file = given if is_mechanism_file(given) else files[name]
            raise InvalidInput(f"{file}: name = {name!r} is taken by another scene; give the one in the file another")
        files |= {name: given} if is_mechanism_file(given) else {}
        scenes[name] = scene
    return scenes


def _read_scene_file(name: str) -> Scene:
    from conrod.scenes.described_scene import read_scene  # what reads units takes its time to load

    return read_scene(Path(name))


def select_engines(names: Sequence[str], left_out: Callable[[str], None] = lambda reason: None) -> list[Engine[Any]]:
    """Find engines by name; `all` gives every installed engine, no name the default engines.

    Args:
        left_out: takes a line on each engine that nobody named and that cannot be loaded.

    Raises:
        InvalidInput: an engine is unknown, or one that was named cannot be loaded.
    """
    named = [engine_named(name) for name in dict.fromkeys(names) if name != ALL_ENGINES]
    if named and ALL_ENGINES not in names:
        return named
    found, reasons = loadable_engines(installed_extras() if names else ())
    for reason in reasons:
        left_out(reason)
    return found


def select_presets(engines: Sequence[Engine[Any]], preset: str | None) -> dict[str, tuple[str, ...]]:
    """Presets to run by engine name: the requested one where the engine has it, or all.

    Raises:
        InvalidInput: no selected engine has the preset.
    """
    known = {name for engine in engines for name in engine.presets}
    if preset is not None and preset not in known:
        others = [name for name in engine_names() if preset in presets_of(name)]
        if others:
            chosen = ", ".join(engine.name for engine in engines)
            raise InvalidInput(
                f"{chosen} has no preset {preset!r}, {' and '.join(others)} has: choose from {', '.join(sorted(known))}"
            )
        raise unknown_choice("preset", preset, known)
    return {e.name: tuple(n for n in e.presets if preset in (None, n)) for e in engines}


def make_plan(
    scenes: Mapping[str, Scene],
    steps_per_revolution: int | None,
    revolutions: int,
    tolerance: Mapping[str, float | str] | None,
    max_samples: int = MAX_KEPT_SAMPLES,
) -> Plan:
    """Make the plan of a validation from checked arguments.

    Raises:
        InvalidInput: a count or a tolerance out of range, or more samples than `max_samples`.
    """
    if steps_per_revolution is not None:
        check_count("--steps-per-rev", steps_per_revolution, *STEPS_RANGE)
    check_count("--revolutions", revolutions, *REVOLUTIONS_RANGE)
    asked = None if tolerance is None else check_tolerance(tolerance, ALL_TOLERANCE_NAMES)
    plan = Plan(steps_per_revolution, float(revolutions), asked)
    for name, scene in scenes.items():
        _check_samples(name, plan.steps(scene), revolutions, max_samples)
    return plan


def check_sample_count(name: str, samples_per_revolution: int, revolutions: int) -> None:
    """Refuse a table of the exact motion with too many samples.

    Raises:
        InvalidInput: a count out of range, or more samples than can be kept.
    """
    check_count("--steps-per-rev", samples_per_revolution, *STEPS_RANGE)
    check_count("--revolutions", revolutions, *REVOLUTIONS_RANGE)
    _check_samples(name, samples_per_revolution, revolutions)


def _check_samples(name: str, steps: int, revolutions: int, max_samples: int = MAX_KEPT_SAMPLES) -> None:
    if (samples := steps * revolutions) > max_samples:
        asked = f"{steps} steps x {revolutions} revolutions = {samples} samples"
        raise InvalidInput(f"{name}: {asked} are too many: there may be {max_samples}")
