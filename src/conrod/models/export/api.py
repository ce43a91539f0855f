"""Models and exact motion of scenes, for other programs."""

from __future__ import annotations

import warnings

from conrod.errors import InvalidInput, unknown_choice
from conrod.execution.resolve_arguments import STEPS_RANGE, OneScene, check_sample_count, scene_by_name
from conrod.mechanism.units import check_count
from conrod.scenes.space import MACHINES

FORMATS = ("mjcf", "csv", "fmu")
CSV_SAMPLES = 360  # a revolution


class NoBinary(UserWarning):
    """Warning that an FMU holds sources alone, because no compiler was found."""


def export(
    scene: OneScene,
    format: str = "mjcf",
    *,
    steps_per_rev: int | None = None,
    revolutions: int | None = None,
) -> str | bytes:
    """Return the MJCF model of a scene, its exact motion as CSV with units, or an FMU 3.0 of it.

    Args:
        scene: a name, a mechanism file, a scene, or a machine in space by name (MJCF alone).
        format: "mjcf", "csv" or "fmu".
        steps_per_rev: time steps of the model, or samples of the motion, in one revolution.
        revolutions: length of the motion, in revolutions of the crank.

    Raises:
        InvalidInput: an argument cannot be used; says what can.
    """
    if format not in FORMATS:
        raise unknown_choice("format", format, FORMATS)
    if format == "mjcf" and isinstance(scene, str) and scene in MACHINES:
        if steps_per_rev is not None or revolutions is not None:
            raise InvalidInput(f"{scene} is a machine in space: its model is written as it is, without options")
        return MACHINES[scene]().mjcf
    name, chosen = scene_by_name(scene)
    if format == "csv":
        from conrod.models.export.pack import as_csv, exact_columns

        return as_csv(exact_columns(chosen, *samples_of(name, steps_per_rev, revolutions, 1)))
    if revolutions is not None or (format == "fmu" and steps_per_rev is not None):
        option = "--steps-per-rev" if revolutions is None else "--revolutions"
        raise InvalidInput(f"{option} does not go with --format {format}: whoever runs a model chooses it")
    if format == "mjcf":
        from conrod.engines.mujoco.standalone import standalone_mjcf

        if steps_per_rev is not None:
            check_count("--steps-per-rev", steps_per_rev, *STEPS_RANGE)
        return standalone_mjcf(name, chosen, steps_per_rev)
    from conrod.models.export.fmu import fmu

    content, why_no_binary = fmu(name, chosen)
    if why_no_binary is not None:
        warnings.warn(f"{name}: the FMU holds sources alone: {why_no_binary}", NoBinary, stacklevel=2)
    return content


def samples_of(name: str, steps_per_rev: int | None, revolutions: int | None, usual: int) -> tuple[int, int]:
    """Samples a revolution and revolutions of an exact motion.

    Raises:
        InvalidInput: they are out of range.
    """
    samples = CSV_SAMPLES if steps_per_rev is None else steps_per_rev
    turns = usual if revolutions is None else revolutions
    check_sample_count(name, samples, turns)
    return samples, turns
