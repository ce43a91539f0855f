"""Known defects in the run that a user's model is judged by, and which of them its verdict notices."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from conrod.own.models.request import DrivenRun
from conrod.own.models.runs import RunReference, judged, tracks_of
from conrod.runs.trajectory import Piece, Trajectory
from conrod.studies.detection.defects import MOTION
from conrod.studies.detection.judging import examined
from conrod.studies.detection.machine_defects import Recording
from conrod.studies.validation.results import Qualified, Tolerance, ValidationResult

if TYPE_CHECKING:
    from conrod.own.models.study import ModelStudy


def qualified(study: ModelStudy, run: DrivenRun, to: RunReference) -> Qualified | None:
    """What the verdict on a model's own settings notices; None where the run is not judged, or did not pass.

    Defects that take a run of their own are not planted, nor masses, which do not show.

    Args:
        run: that stands for its own settings.
    """
    own, version, limits = study.own, study.model.engine_version, dict[str, Any](study.limits)
    if own is None or not study.tolerance or own.errors is None or study.exceeded(own):
        return None
    settings: Any = run  # of which the time step alone is asked for
    trajectory = Trajectory(
        "mujoco", version, settings, to.speed, to.turns, run.outcome, run.reason, tracks_of(run, to), None
    )
    given = Recording(Piece(trajectory, 0, run.times, run.warnings, None, None), to.exact, None)

    def judge(planted: Recording) -> ValidationResult:
        found = judged(own.label, run, replace(to, exact=planted.reference), planted.run.trajectory.points)
        errors = {
            point: {quantity: vars(curve.size) for quantity, curve in curves.items()}
            for point, curves in (found.errors or {}).items()
        }
        return ValidationResult(
            scene=study.scene_name, parameters={}, engine="mujoco", engine_version=version, preset=None,
            mode="dynamic", revolutions=to.turns, outcome=found.outcome.slug, reason=found.reason, errors=errors,
            phase={"max": found.phase}, tolerance=Tolerance(**limits),
        ).judged()  # fmt: skip

    return Qualified(tuple(one for defect in MOTION if (one := examined(defect, given, judge))), ())
