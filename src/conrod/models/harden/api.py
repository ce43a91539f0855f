"""Closed loops of a MuJoCo model that are made to stay closed."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, overload

from conrod.errors import InvalidInput
from conrod.execution.local import call_on_file
from conrod.mjcf.request import controls_of, size_of_unit
from conrod.models.harden.results import HardenedModel
from conrod.user_files.files import check_readable
from conrod.user_files.in_memory import file_of_model

if TYPE_CHECKING:
    import mujoco

LONGEST_RUN = 1e9  # [s]


@overload
def harden(model: mujoco.MjModel, factor: float = ...) -> None: ...
@overload
def harden(
    model: str | Path | mujoco.MjSpec,
    *,
    keyframe: str | None = ...,
    controls: Mapping[str, float] | None = ...,
    seconds: float | None = ...,
    force: bool = ...,
    write: bool = ...,
    unit: str | None = ...,
) -> HardenedModel: ...
def harden(
    model: str | Path | mujoco.MjModel | mujoco.MjSpec,
    factor: float | None = None,
    *,
    keyframe: str | None = None,
    controls: Mapping[str, float] | None = None,
    seconds: float | None = None,
    force: bool = False,
    write: bool = False,
    unit: str | None = None,
) -> HardenedModel | None:
    """Make the closed loops of a MuJoCo model stay closed.

    A compiled model (`MjModel`) is changed in place, see `conrod.engines.mujoco.compiled_edits.harden`. A file
    or specification is left alone: runs with and without hardening show what it changes.

    Args:
        model: compiled, or the path of an MJCF or binary file, or an `MjSpec`.
        factor: factor on the inverse weights of a compiled model, in (0, 1].
        keyframe, controls: as in `lint`.
        seconds: length of the runs [s]; None for 1, or what fits the step of the model.
        force: harden closures that seem soft on purpose, or whose run breaks off when they are hard.
        write: whether the result has the hardened model, in binary form, as its `content`.
        unit: as in `lint`.

    Raises:
        InvalidInput: the model or an argument cannot be used; says what can.
        ValueError: the factor is out of range.
    """
    from conrod.engines.mujoco import compiled_edits

    if not isinstance(model, str | Path) and not hasattr(model, "compile"):
        compiled_edits.harden(model, **({} if factor is None else {"factor": factor}))
        return None
    from conrod.models.harden.study import harden_file

    if seconds is not None and not 0.0 < seconds < LONGEST_RUN:
        raise InvalidInput(f"--seconds {seconds:g}: give a finite number above 0")
    with file_of_model(model) as (path, _):
        check_readable(path)
        given, size = controls_of(controls or {}), size_of_unit(unit)
        return call_on_file(harden_file, path, keyframe, seconds, force, write, given, size)
