"""conrod: physics engines, cross-validated against mechanisms whose motion is known exactly.

import conrod

found = conrod.validate("saw-500rpm", engines="mujoco")
print(found.passed, found.verdict)
found.write("reports/saw")
"""

# No library is imported here, not even __future__: the working folder may still be searched, see `__main__`.
from conrod.slices import SLICES

TYPE_CHECKING = False
if TYPE_CHECKING:
    from conrod.comparison.compare import Comparison as Comparison
    from conrod.comparison.compare import compare as compare
    from conrod.comparison.trajectory import Outcome as Outcome
    from conrod.comparison.trajectory import Trajectory as Trajectory
    from conrod.engines.mujoco import MuJoCoSettings as MuJoCoSettings
    from conrod.engines.pymunk import PymunkSettings as PymunkSettings
    from conrod.engines.run import run as run
    from conrod.errors import InvalidInput as InvalidInput
    from conrod.exact.kinematics import GenericReference as GenericReference
    from conrod.exact.kinematics import Kinematics as Kinematics
    from conrod.exact.linkage import instant_quantities as instant_quantities
    from conrod.execution.baseline import BaselineComparison as BaselineComparison
    from conrod.execution.baseline import Drift as Drift
    from conrod.execution.resolve_arguments import family as family
    from conrod.execution.resolve_arguments import scene as scene
    from conrod.execution.runner import Runs as Runs
    from conrod.guide.doctor.api import doctor as doctor
    from conrod.guide.explain.api import explain as explain
    from conrod.guide.init.api import begin_project as begin_project
    from conrod.mechanism.mechanism import Mechanism as Mechanism
    from conrod.models.check.api import check_model as check_model
    from conrod.models.check.dispatch import check as check
    from conrod.models.engine_comparison.api import check_loops_in_engines as check_loops_in_engines
    from conrod.models.export.api import export as export
    from conrod.models.fmu.api import check_fmu as check_fmu
    from conrod.models.harden.api import harden as harden
    from conrod.models.inspection.api import inspect_model as inspect_model
    from conrod.models.invariances.api import invariances as invariances
    from conrod.models.lint.api import lint as lint
    from conrod.models.loops.api import check_loops as check_loops
    from conrod.models.printed.api import audit as audit
    from conrod.models.tables.api import check_table as check_table
    from conrod.models.torque_runs.api import check_torque_run as check_torque_run
    from conrod.models.upgrades.api import compare_releases as compare_releases
    from conrod.report.findings import Findings as Findings
    from conrod.scenes import SCENES as SCENES
    from conrod.scenes import CamFollower as CamFollower
    from conrod.scenes import Saw as Saw
    from conrod.scenes import Scene as Scene
    from conrod.scenes import ShearPress as ShearPress
    from conrod.studies.ablate.api import ablate as ablate
    from conrod.studies.forces.api import forces as forces
    from conrod.studies.free_motion.api import free_motion as free_motion
    from conrod.studies.limits.api import limits as limits
    from conrod.studies.space.api import validate_in_space as validate_in_space
    from conrod.studies.sweep.api import recommend as recommend
    from conrod.studies.sweep.api import sweep as sweep
    from conrod.studies.validation.api import validate as validate
    from conrod.studies.versions.api import versions as versions

    __version__: str

# Environment of all that conrod starts, and that libraries start there: MuJoCo, where something is to be drawn, loads
# GLFW, which has an interpreter of its own look at a library.
SAFE_PATH = {"PYTHONSAFEPATH": "1", "MUJOCO_GL": "disable"}
# Threads of linear algebra, unless the user asks for others. Matrices are small and processes many: more would get in
# each other's way, and last digits depend on the number of cores.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}

# Public names by the module they live in: loaded on first use, so that `conrod --help` loads neither engine nor numpy.
_PUBLIC = {
    "conrod.comparison.compare": ("Comparison", "compare"),
    "conrod.comparison.trajectory": ("Outcome", "Trajectory"),
    "conrod.engines.mujoco": ("MuJoCoSettings",),
    "conrod.engines.pymunk": ("PymunkSettings",),
    "conrod.engines.run": ("run",),
    "conrod.errors": ("InvalidInput",),
    "conrod.exact.kinematics": ("GenericReference", "Kinematics"),
    "conrod.exact.linkage": ("instant_quantities",),
    "conrod.execution.baseline": ("BaselineComparison", "Drift"),
    "conrod.execution.resolve_arguments": ("family", "scene"),
    "conrod.execution.runner": ("Runs",),
    "conrod.mechanism.mechanism": ("Mechanism",),
    "conrod.report.findings": ("Findings",),
    "conrod.scenes": ("SCENES", "CamFollower", "Saw", "Scene", "ShearPress"),
}
_HOMES: dict[str, str] = {}
for _module, _names in _PUBLIC.items():
    _HOMES |= dict.fromkeys(_names, _module)
for _slice in SLICES:
    _HOMES |= {_name: f"{_slice.package}.{_module}" for _name, _module in _slice.functions.items()}

__all__ = ["__version__"]
__all__ += list(_HOMES)


def __getattr__(name: str) -> object:
    if name == "__version__":
        # Here: until the command line answers it, Ctrl-C is a traceback, and this takes a while to import.
        from importlib.metadata import version

        return globals().setdefault(name, version("conrod"))
    if name not in _HOMES:
        raise AttributeError(f"module 'conrod' has no attribute {name!r}; it has {', '.join(sorted(_HOMES))}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
