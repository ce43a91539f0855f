"""What was found of the runs of a user's model, in sentences."""

from __future__ import annotations

from collections.abc import Mapping

from conrod.report import numbers
from conrod.studies.user_model.runs import QUANTITIES, JudgedRun
from conrod.studies.user_model.study import EXACT_SOLVER, OWN, ModelStudy

HEAD = ("settings", "steps/rev", *QUANTITIES, "verdict")


def rows(study: ModelStudy) -> list[list[str]]:
    """The runs as a table."""
    return [_row(study, run) for run in study.runs.values()]


def _row(study: ModelStudy, run: JudgedRun) -> list[str]:
    errors = [numbers.measured(run.worst(quantity)) for quantity in QUANTITIES]
    if run.errors is None:
        told = f"{run.outcome.slug}: {run.reason}"
    elif run is study.own and study.tolerance:
        told = "OUT OF TOLERANCE" if study.exceeded() else "within tolerance"
    elif run.label == OWN and run is not study.own:
        told = "contains what the drive changes"
    else:
        told = "measured"
    return [run.label, numbers.quantity(run.steps_per_revolution, 5), *errors, told]


def drive(study: ModelStudy) -> list[str]:
    """What drove the crank, and what that did."""
    own = study.own
    if own is None:
        return ["not driven: it is too far off the machine for its runs to say anything"]
    told = [
        f"crank driven by an armature of {numbers.quantity(own.armature, 3)} set in the compiled model: speed constant "
        f"to {numbers.measured(own.ripple)}, crank angle off the nominal by {numbers.measured(own.phase)} rad"
    ]
    share: Mapping[str, float] | None = study.drive_share
    if share is not None:
        sizes = ", ".join(f"{name} {numbers.measured(size)}" for name, size in share.items())
        told.append(
            f"with the solver tolerance at 0 the errors change by {sizes}: that is the drive's, not the model's"
        )
    elif EXACT_SOLVER not in study.runs and OWN in study.runs:
        told.append("the solver tolerance is 0 as it is: the drive takes nothing from it")
    elif EXACT_SOLVER in study.runs:
        told.append("what the drive changes could not be told: a run did not complete")
    told += [f"{preset}: {reason}" for preset, reason in study.refused.items()]
    if own.warnings:
        told.append("warnings of the engine: " + ", ".join(f"{n} {count}x" for n, count in own.warnings.items()))
    left_out = [name for name in study.identity.off_by if name not in study.points]
    if left_out:
        told.append(f"compared without {', '.join(left_out)}, which is not where it should be")
    if study.identity.explanations:
        told.append("compared with the exact motion of the lengths that were found")
    elif not study.is_machine and not study.identity.other_branch:
        told.append("the errors contain what the lengths do not explain")
    return told


def own_settings(study: ModelStudy) -> str:
    """The settings that the model comes with."""
    has = study.scan.settings
    softness = ", ".join(f"{a:g} {b:g}" for a, b in has.closure_solref) or "none"
    impedance = ", ".join(f"{a:g} {b:g}" for a, b in has.closure_impedance) or "none"
    return (
        f"timestep {has.timestep:g} s, integrator {has.integrator}, solver {has.solver}, {has.iterations} iterations, "
        f"tolerance {has.tolerance:g}; closures: solref {softness}, solimp {impedance}; gravity "
        f"{' '.join(f'{g:g}' for g in has.gravity)}"
    )
