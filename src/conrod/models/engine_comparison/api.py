"""The closed loops of users' models in several engines, compared with their own exact motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from conrod.errors import InvalidInput, as_mapping, as_names
from conrod.execution.local import call_named, call_on_file
from conrod.execution.resolve_arguments import (
    ALL_ENGINES,
    REVOLUTIONS_RANGE,
    STEPS_RANGE,
    Engines,
    engine_names_given,
    select_presets,
)
from conrod.execution.runner import Runs
from conrod.execution.tolerances import check_tolerance
from conrod.mechanism.units import check_count
from conrod.mjcf.loop_results import LoopRequest
from conrod.mjcf.request import size_of_unit
from conrod.report.findings import Findings, text_of_call
from conrod.studies.space.api import (
    MAX_STEPS,
    engines_in_space,
    judge_result,
    refuse_finer_than_precision,
    run_cells,
    steps_to_run,
)
from conrod.studies.space.plan import SpatialCell
from conrod.studies.space.report import SPACE_REPORT
from conrod.studies.space.results import UNITS, SpatialStudy
from conrod.user_files.files import check_readable
from conrod.user_files.in_memory import file_of_model

if TYPE_CHECKING:
    import mujoco

    from conrod.models.engine_comparison.study import ReadModel

READER = "conrod.models.engine_comparison.study.read_model"


def check_loops_in_engines(
    model: str | Path | mujoco.MjModel | mujoco.MjSpec | Sequence[str | Path],
    *,
    drives: Mapping[str, str],
    engines: Engines = ALL_ENGINES,
    preset: str | None = None,
    steps_per_rev: int | Sequence[int] | None = None,
    revolutions: int = 1,
    points: str | Sequence[str] = (),
    keyframe: str | None = None,
    tolerance: Mapping[str, float | str] | None = None,
    unit: str | None = None,
    while_reading: Callable[[str], AbstractContextManager[object]] = nullcontext,
    runs: Runs | None = None,
) -> Findings[SpatialStudy]:
    """Compare engines on the closed loops of MuJoCo models, by the exact motion of each.

    Engines are given bodies, joints, closures and gravity; parts that do not move against each other as one body.

    Args:
        model: paths of MJCF or binary files, or a model in memory.
        drives: law of each driven joint, such as `{"hip": "60rpm"}`.
        engines, preset, tolerance, runs: as in `validate_in_space`.
        steps_per_rev: time steps in a period of the slowest drive; those of the file's own step where none is given.
            Half of them are run as well, for the order.
        revolutions: periods of the slowest drive that are run.
        points, keyframe, unit: as in `check_loops`.
        while_reading: called with the name of each model, for a context in which it is read.

    Raises:
        InvalidInput: a model or an argument cannot be used; says what can.
    """
    able = engines_in_space(engines)
    presets = select_presets(able, preset)
    check_count("--revolutions", revolutions, *REVOLUTIONS_RANGE)
    asked = None if tolerance is None else check_tolerance(tolerance, UNITS)
    laws = as_mapping("drives", drives, "{'hip': '60 rpm'}")
    places = tuple(place.removeprefix("site:").removeprefix("body:") for place in as_names(points))
    question = LoopRequest(laws, keyframe, points=places, unit=size_of_unit(unit))
    several = [model] if isinstance(model, str | Path) or not isinstance(model, Sequence) else list(model)
    studies, typed = dict[str, SpatialStudy](), dict[str, str]()
    for one in several:
        with while_reading(str(one)), file_of_model(one) as (path, shown):
            check_readable(path)
            name = shown or path.stem
            if name in studies:
                raise InvalidInput(f"{one}: another has the same name in the report: judge it by itself")
            read: ReadModel = call_on_file(call_named, path, READER, question, revolutions)
        path_of_steps = _steps_of(read, steps_per_rev, revolutions)
        cells = [
            SpatialCell(name, engine.name, each, path_of_steps, revolutions, read.model)
            for engine in able
            for each in presets[engine.name]
        ]
        scales = read.model.scales
        too_coarse = refuse_finer_than_precision(able, engines, asked or {}, [scales])
        found = run_cells(cells, runs or Runs(), too_coarse)
        results = tuple(judge_result(result, asked, scales) for result in found)
        studies[name] = SpatialStudy(name, name, read.drives, scales, results, str(one), read.remarks)
        typed[name] = str(one)
    call = text_of_call(
        "check_loops_in_engines",
        [str(one) if isinstance(one, str | Path) else "the model" for one in several],
        drives=laws,
        engines=None if engine_names_given(engines) == (ALL_ENGINES,) else engine_names_given(engines),
        preset=preset,
        steps_per_rev=steps_per_rev,
        revolutions=None if revolutions == 1 else revolutions,
        points=places,
        keyframe=keyframe,
        tolerance=tolerance,
        unit=unit,
    )
    return Findings(SPACE_REPORT, studies, call, typed=typed)


def _steps_of(read: ReadModel, asked: int | Sequence[int] | None, revolutions: int) -> tuple[int, ...]:
    """Numbers of steps in a period of the slowest drive: as asked for, or by the file's own time step."""
    own = max(STEPS_RANGE[0], round(read.model.start.period / read.timestep))
    path = steps_to_run(own if asked is None else asked)
    if path[-1] * revolutions > MAX_STEPS:
        raise InvalidInput(
            f"{path[-1] * revolutions:,} steps are too many: a run may have {MAX_STEPS:,}; --steps-per-rev takes fewer"
        )
    return path
