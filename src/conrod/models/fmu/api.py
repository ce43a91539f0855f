"""An FMU, run and judged by the exact motion of the scene that it is to be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from conrod.errors import as_names
from conrod.exact.link_rotations import rotating_links
from conrod.execution.resolve_arguments import REVOLUTIONS_RANGE, OneScene, scene_by_name
from conrod.execution.runner import RUN_TIMEOUT
from conrod.execution.tolerances import ALL_TOLERANCE_NAMES, check_tolerance
from conrod.mechanism.units import check_count
from conrod.models.tables.api import column_texts, table_findings
from conrod.models.tables.columns import column_request
from conrod.models.tables.estimation import check_estimated
from conrod.models.tables.study import TableStudy, study_table
from conrod.report.findings import Findings, text_of_call
from conrod.scenes import Scene
from conrod.user_files.files import check_readable

STEPS = 1000  # a revolution
TURNS = 2


def check_fmu(
    fmu: str | Path,
    scene: OneScene,
    *,
    columns: Mapping[str, str] | None = None,
    units: str | Sequence[str] = (),
    estimate: str | Sequence[str] = (),
    preset: str | None = None,
    steps_per_rev: int = STEPS,
    revolutions: int = TURNS,
    tolerance: Mapping[str, float | str] | None = None,
    timeout: float = RUN_TIMEOUT,
    baseline: str | Path | None = None,
    accept: bool = False,
) -> Findings[TableStudy]:
    """Run an FMU and judge its trajectory by the exact motion of a scene.

    Args:
        fmu: path of an FMU 2.0 or 3.0.
        preset: interface of the FMU that is run, "model-exchange" or "co-simulation"; None for what it has.
        steps_per_rev: communication steps in one revolution.
        timeout: longest wall time of the run [s].
        scene, columns, units, estimate, revolutions, tolerance, baseline, accept: as in `check_table`.

    Raises:
        InvalidInput: the FMU or an argument cannot be used; says what can.
    """
    path = Path(fmu)
    check_readable(path)
    check_count("--revolutions", revolutions, *REVOLUTIONS_RANGE)
    name, machine = scene_by_name(scene)
    units, estimate = as_names(units), as_names(estimate)
    wanted = column_request(columns or {}, units, tuple(machine.lengths), rotating_links(machine.kinematics))
    allowed = None if tolerance is None else check_tolerance(tolerance, ALL_TOLERANCE_NAMES)

    def judge(one: Scene) -> TableStudy:
        from conrod.models.fmu.fmu import run_fmu

        reading = run_fmu(path, one, wanted, preset, steps_per_rev, float(revolutions), timeout)
        return study_table(str(path), name, one, reading, check_estimated(estimate), allowed)

    options: dict[str, Any] = {
        "column": column_texts(columns),
        "unit": units,
        "estimate": ",".join(estimate),
        "preset": preset,
    }
    options |= {"steps-per-rev": None if steps_per_rev == STEPS else steps_per_rev}
    options |= {"revolutions": None if revolutions == TURNS else revolutions}
    given = {"columns": columns, "units": units, "estimate": estimate, "preset": preset, "tolerance": tolerance}
    given |= {"steps_per_rev": options["steps-per-rev"], "revolutions": options["revolutions"]}
    call = text_of_call("check_fmu", str(path), name, **given)
    return table_findings(judge, path, None, (name, machine), options, (baseline, accept), call)
