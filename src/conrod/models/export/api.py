"""Models and exact motion of scenes, for other programs."""

from __future__ import annotations

import warnings

import numpy as np

from conrod.engines import engine_named
from conrod.engines.engine import default_steps, judged_preset, step_length
from conrod.engines.tracks import Pace
from conrod.errors import ConrodWarning, InvalidInput, unknown_choice
from conrod.exact.dynamics.forward import ForwardDynamics
from conrod.exact.motion import Array
from conrod.execution.resolve_arguments import STEPS_RANGE, OneScene, check_sample_count, scene_by_name
from conrod.mechanism.loads import TimePulse
from conrod.mechanism.units import check_count
from conrod.scenes import Scene
from conrod.scenes.space import MACHINES

MODELS = ("mjcf", "pymunk")
TABLES = ("csv", "npz")
FORMATS = (*MODELS, *TABLES, "fmu")
CSV_SAMPLES = 360  # a revolution


def export(
    scene: OneScene,
    format: str = "mjcf",
    *,
    steps_per_rev: int | None = None,
    revolutions: int | None = None,
    preset: str | None = None,
    engine: str | None = None,
    free: bool = False,
    motor: bool = False,
) -> str | bytes:
    """Return the model of a scene for MuJoCo or pymunk, its motion as a table with units, or an FMU 3.0 of it.

    Args:
        scene: a name, a mechanism file, a scene, or a machine in space by name (MJCF alone).
        format: "mjcf", "pymunk" (a Python module that needs pymunk alone), "csv", "npz" (numpy) or "fmu".
        steps_per_rev: time steps of the model, or samples of the motion, in one revolution.
        revolutions: length of the motion, in revolutions of the crank.
        preset: settings of a pymunk model, or of the engine's run; None for the preset that is judged.
        engine: of a table, the engine whose run is sampled beside the exact motion; None for the exact motion alone.
        free: whether the model has no drive, so that its crank moves as weight and loads demand; else the crank is
            driven at constant speed.
        motor: whether the crank of a model without a drive has a motor, whose torque and rate are set.

    Raises:
        InvalidInput: an argument cannot be used; says what can.
    """
    if format not in FORMATS:
        raise unknown_choice("format", format, FORMATS)
    check_model_options(format, preset, free, motor, engine)
    if format == "mjcf" and isinstance(scene, str) and scene in MACHINES:
        if steps_per_rev is not None or revolutions is not None or free:
            raise InvalidInput(f"{scene} is a machine in space: its model is written as it is, without options")
        return MACHINES[scene]().mjcf
    name, chosen = scene_by_name(scene)
    if format in TABLES:
        return _table(name, chosen, format, engine, preset, steps_per_rev, revolutions)
    if revolutions is not None or (format == "fmu" and steps_per_rev is not None):
        option = "--steps-per-rev" if revolutions is None else "--revolutions"
        raise InvalidInput(f"{option} does not go with --format {format}: whoever runs a model chooses it")
    if steps_per_rev is not None:
        check_count("--steps-per-rev", steps_per_rev, *STEPS_RANGE)
    if format == "mjcf" and not free:
        from conrod.engines.mujoco.standalone import standalone_mjcf

        return standalone_mjcf(name, chosen, steps_per_rev)
    if format == "mjcf":
        return _free_mjcf(name, chosen, steps_per_rev, motor)
    if format == "pymunk":
        return _pymunk_module(name, chosen, steps_per_rev, preset, free, motor)
    from conrod.models.export.fmu import fmu

    content, why_no_binary = fmu(name, chosen)
    if why_no_binary is not None:
        warnings.warn(f"{name}: the FMU holds sources alone: {why_no_binary}", ConrodWarning, stacklevel=2)
    return content


def _table(
    name: str, scene: Scene, format: str, engine: str | None, preset: str | None, steps: int | None,
    revolutions: int | None,
) -> str | bytes:  # fmt: skip
    """Return a table (CSV or NPZ) of the exact motion, or of an engine's run and the exact motion."""
    from conrod.models.export.pack import as_csv, exact_columns
    from conrod.models.export.sampled import exact_trajectory, sampled_csv, sampled_npz, sampled_trajectory

    if engine is not None:
        sampled = sampled_trajectory(name, scene, engine, preset, steps, revolutions)
        if sampled.outcome:
            warnings.warn(f"{name} in {engine}: the run is {sampled.outcome}", ConrodWarning, stacklevel=3)
        return sampled_csv(sampled) if format == "csv" else sampled_npz(sampled)
    samples = samples_of(name, steps, revolutions, 1)
    if format == "csv":
        return as_csv(exact_columns(scene, *samples))
    return sampled_npz(exact_trajectory(name, scene, *samples))


def check_model_options(format: str, preset: str | None, free: bool, motor: bool, engine: str | None = None) -> None:
    """Refuse options of models and of runs with a format that does not have them.

    Raises:
        InvalidInput: names the option.
    """
    if engine is not None and format not in TABLES:
        raise InvalidInput(f"--engine does not go with --format {format}: a run is sampled as {' or '.join(TABLES)}")
    if preset is not None and format != "pymunk" and engine is None:
        needs = ": of a table it is that of an --engine" if format in TABLES else ""
        raise InvalidInput(f"--preset does not go with --format {format}{needs}")
    if (free or motor) and format not in MODELS:
        raise InvalidInput(f"{'--free' if free else '--motor'} does not go with --format {format}")
    if motor and not free:
        raise InvalidInput("--motor goes with --free: without it the crank has its drive")


def _pymunk_module(
    name: str, scene: Scene, steps_per_rev: int | None, preset: str | None, free: bool, motor: bool
) -> str:
    """Python module that builds a scene in pymunk, with the settings of a preset."""
    from conrod.engines.pymunk import PymunkSettings
    from conrod.engines.pymunk.standalone import standalone_free_module, standalone_module

    engine, steps = engine_named("pymunk"), steps_per_rev or default_steps(scene)
    chosen = judged_preset(engine) if preset is None else preset
    if chosen not in engine.presets:
        raise unknown_choice("preset of pymunk", chosen, engine.presets)
    if not free:
        return standalone_module(name, scene, engine.presets[chosen](scene, steps))
    settings = PymunkSettings.for_free_motion(scene.kinematics.mechanism, chosen, step_length(scene, steps))
    return standalone_free_module(name, scene, free_start(name, scene, motor), settings, motor)


def _free_mjcf(name: str, scene: Scene, steps_per_rev: int | None, motor: bool) -> str:
    """MJCF model of a scene without a drive, with the settings that MJCF can say best."""
    from conrod.engines.mujoco.free_run import free_settings
    from conrod.engines.mujoco.standalone import standalone_free_mjcf

    step = step_length(scene, steps_per_rev or default_steps(scene))
    pace = Pace(scene.period, crosses_branches=False)  # of which `tuned` takes nothing
    settings = free_settings(scene.kinematics.mechanism, "tuned", step, pace)
    return standalone_free_mjcf(name, scene, free_start(name, scene, motor), settings, motor)


def samples_of(name: str, steps_per_rev: int | None, revolutions: int | None, usual: int) -> tuple[int, int]:
    """Return samples per revolution, and revolutions, of an exact motion.

    Raises:
        InvalidInput: a number is out of range.
    """
    samples = CSV_SAMPLES if steps_per_rev is None else steps_per_rev
    turns = usual if revolutions is None else revolutions
    check_sample_count(name, samples, turns)
    return samples, turns


def free_start(name: str, scene: Scene, motor: bool = False) -> tuple[Array, Array]:
    """Exact poses and rates (3 n,) [m, m, rad] of all bodies at the start.

    Args:
        motor: whether a motor on the crank will end a rest.

    Raises:
        InvalidInput: the joints do not allow the start, or the machine rests and nothing moves it.
    """
    mechanism = scene.kinematics.mechanism
    if motor and not any(scene.start_rates.values()):
        poses = scene.kinematics.start[0]
        return poses, np.zeros_like(poses)
    motion = ForwardDynamics(mechanism).motion(np.zeros(1), rates=scene.start_rates)
    pulsed = any(isinstance(load.law, TimePulse) for load in mechanism.loads)
    if not (motion.rates.any() or motion.accelerations.any() or pulsed):
        raise InvalidInput(f"--free: {name} rests, and no weight or load moves it: --motor gives its crank a motor")
    return motion.poses[0], motion.rates[0]
