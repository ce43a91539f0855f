"""conrod: physics engines, cross-validated against mechanisms whose motion is known exactly.

import conrod

found = conrod.validate("saw-500rpm", engines="mujoco")
print(found.passed, found.verdict)
found.write("reports/saw")
"""

# Nothing is imported here, not even from __future__: the working folder may still be searched, see `__main__`.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from conrod.api.ablate import ablate as ablate
    from conrod.api.audit import audit as audit
    from conrod.api.check import check as check
    from conrod.api.export import export as export
    from conrod.api.fmu import check_fmu as check_fmu
    from conrod.api.forces import forces as forces
    from conrod.api.free_motion import free_motion as free_motion
    from conrod.api.harden import harden as harden
    from conrod.api.invariances import invariances as invariances
    from conrod.api.limits import limits as limits
    from conrod.api.lint import lint as lint
    from conrod.api.loops import check_loops as check_loops
    from conrod.api.model import check_model as check_model
    from conrod.api.sweep import recommend as recommend
    from conrod.api.sweep import sweep as sweep
    from conrod.api.table import check_table as check_table
    from conrod.api.validate import validate as validate
    from conrod.api.versions import versions as versions
    from conrod.engines.mujoco import MuJoCoSettings as MuJoCoSettings
    from conrod.engines.pymunk import PymunkSettings as PymunkSettings
    from conrod.engines.run import run as run
    from conrod.errors import InvalidInput as InvalidInput
    from conrod.exact import GenericReference as GenericReference
    from conrod.exact.kinematics import Kinematics as Kinematics
    from conrod.mechanism.mechanism import Mechanism as Mechanism
    from conrod.report.findings import Findings as Findings
    from conrod.runs.comparison import Comparison as Comparison
    from conrod.runs.comparison import compare as compare
    from conrod.runs.trajectory import Outcome as Outcome
    from conrod.runs.trajectory import Trajectory as Trajectory
    from conrod.scenes import SCENES as SCENES
    from conrod.scenes import CamFollower as CamFollower
    from conrod.scenes import Saw as Saw
    from conrod.scenes import Scene as Scene
    from conrod.scenes import ShearPress as ShearPress
    from conrod.studies.execution.runner import Runs as Runs
    from conrod.studies.frame.baseline import BaselineComparison as BaselineComparison
    from conrod.studies.frame.baseline import Drift as Drift
    from conrod.studies.frame.resolve_arguments import scene as scene

    __version__: str

# Environment of all that conrod starts, and that libraries start there: MuJoCo, where something is to be drawn, loads
# GLFW, which has an interpreter of its own look at a library.
SAFE_PATH = {"PYTHONSAFEPATH": "1", "MUJOCO_GL": "disable"}
# Threads of linear algebra, unless the user asks for others. Matrices are small and processes many: more would get in
# each other's way, and last digits depend on the number of cores.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}

# Public names by the module they live in: loaded on first use, so that `conrod --help` loads neither engine nor numpy.
_PUBLIC = {
    "conrod.api.ablate": ("ablate",),
    "conrod.api.audit": ("audit",),
    "conrod.api.check": ("check",),
    "conrod.api.model": ("check_model",),
    "conrod.api.table": ("check_table",),
    "conrod.api.fmu": ("check_fmu",),
    "conrod.api.export": ("export",),
    "conrod.api.forces": ("forces",),
    "conrod.api.free_motion": ("free_motion",),
    "conrod.api.invariances": ("invariances",),
    "conrod.api.limits": ("limits",),
    "conrod.api.loops": ("check_loops",),
    "conrod.api.harden": ("harden",),
    "conrod.api.lint": ("lint",),
    "conrod.api.sweep": ("recommend", "sweep"),
    "conrod.api.validate": ("validate",),
    "conrod.api.versions": ("versions",),
    "conrod.engines.mujoco": ("MuJoCoSettings",),
    "conrod.engines.pymunk": ("PymunkSettings",),
    "conrod.engines.run": ("run",),
    "conrod.errors": ("InvalidInput",),
    "conrod.exact.kinematics": ("Kinematics",),
    "conrod.exact": ("GenericReference",),
    "conrod.mechanism.mechanism": ("Mechanism",),
    "conrod.report.findings": ("Findings",),
    "conrod.studies.execution.runner": ("Runs",),
    "conrod.runs.comparison": ("Comparison", "compare"),
    "conrod.runs.trajectory": ("Outcome", "Trajectory"),
    "conrod.scenes": ("SCENES", "CamFollower", "Saw", "Scene", "ShearPress"),
    "conrod.studies.frame.baseline": ("BaselineComparison", "Drift"),
    "conrod.studies.frame.resolve_arguments": ("scene",),
}
_HOMES: dict[str, str] = {}
for _module, _names in _PUBLIC.items():
    _HOMES |= dict.fromkeys(_names, _module)

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
