"""A user's own MuJoCo model, inspected: whether it loads, closes and moves, and how exact it is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from conrod.errors import InvalidInput, as_mapping
from conrod.execution.local import call_on_file
from conrod.mjcf.request import controls_of, size_of_unit
from conrod.models.inspection.report import INSPECTION_REPORT
from conrod.models.inspection.results import Inspection, InspectionRequest
from conrod.report.findings import Findings, text_of_call
from conrod.user_files.files import check_readable
from conrod.user_files.in_memory import file_of_model

if TYPE_CHECKING:
    import mujoco


def inspect_model(
    model: str | Path | mujoco.MjModel | mujoco.MjSpec | Sequence[str | Path],
    *,
    keyframe: str | None = None,
    drives: Mapping[str, str] | None = None,
    controls: Mapping[str, float] | None = None,
    unit: str | None = None,
    progress: Callable[[str], object] = lambda name: None,
) -> Findings[Inspection]:
    """Say what MuJoCo models are: whether they load, close and move, how exact they are, and what to do next.

    Args:
        model: paths of MJCF or binary files, or a model in memory.
        keyframe: keyframe to start from; None for the first, "qpos0" for none.
        drives: law of each actuator or joint, such as `{"servo": "sine:20deg,1Hz"}`; None to try all actuators.
        controls: inputs of actuators in place of the keyframe's, in MuJoCo's units.
        unit: unit of the model's lengths: m, cm, mm or inch; metres where none is given.
        progress: called with the name of each model before it is inspected.

    Raises:
        InvalidInput: the model or an argument cannot be used; says what can.
    """
    laws = as_mapping("drives", drives, "{'crank': '60 rpm'}")
    question = InspectionRequest(keyframe, laws, controls_of(controls or {}), size_of_unit(unit))
    several = [model] if isinstance(model, str | Path) or not isinstance(model, Sequence) else list(model)
    found, typed = dict[str, Inspection](), dict[str, str]()
    for one in several:
        progress(str(one))
        with file_of_model(one) as (path, shown):
            check_readable(path)
            part = shown or path.stem
            if part in found:
                raise InvalidInput(f"{one}: another has the same name in the report: inspect it by itself")
            found[part] = replace(_inspect_file(path, question, part), file=shown or str(path))
            typed[part] = str(one)
    asked = [str(one) if isinstance(one, str | Path) else "the model" for one in several]
    call = text_of_call("inspect_model", asked, keyframe=keyframe, drives=drives, controls=controls, unit=unit)
    return Findings(INSPECTION_REPORT, found, call, typed=typed)


def _inspect_file(path: Path, question: InspectionRequest, name: str) -> Inspection:
    """Inspect a model file in another process."""
    from conrod.models.inspection.study import inspect

    return call_on_file(inspect, path, question, name)
