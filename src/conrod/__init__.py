"""conrod: physics engines, cross-validated against mechanisms whose motion is known exactly.

from conrod import MuJoCoSettings, Saw, compare, run

saw = Saw(speed=52.36)
trajectory = run(saw, MuJoCoSettings.hardened(saw, steps_per_revolution=500), revolutions=2)
print(compare(trajectory, saw).worst("position"))
"""

# Nothing is imported here, not even from __future__: the working folder may still be searched, see `__main__`.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from conrod.cli.check import Checked as Checked
    from conrod.cli.check import check as check
    from conrod.engines.mujoco import MuJoCoSettings as MuJoCoSettings
    from conrod.engines.mujoco.compiled_edits import harden as harden
    from conrod.engines.pymunk import PymunkSettings as PymunkSettings
    from conrod.engines.run import run as run
    from conrod.errors import InvalidInput as InvalidInput
    from conrod.exact import GenericReference as GenericReference
    from conrod.exact.kinematics import Kinematics as Kinematics
    from conrod.mechanism.mechanism import Mechanism as Mechanism
    from conrod.runs.comparison import Comparison as Comparison
    from conrod.runs.comparison import compare as compare
    from conrod.runs.trajectory import Outcome as Outcome
    from conrod.runs.trajectory import Trajectory as Trajectory
    from conrod.scenes import SCENES as SCENES
    from conrod.scenes import CamFollower as CamFollower
    from conrod.scenes import Saw as Saw
    from conrod.scenes import Scene as Scene
    from conrod.scenes import ShearPress as ShearPress
    from conrod.studies.frame.baseline import Drift as Drift
    from conrod.studies.frame.baseline import Held as Held
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
    "conrod.cli.check": ("Checked", "check"),
    "conrod.engines.mujoco": ("MuJoCoSettings",),
    "conrod.engines.mujoco.compiled_edits": ("harden",),
    "conrod.engines.pymunk": ("PymunkSettings",),
    "conrod.engines.run": ("run",),
    "conrod.errors": ("InvalidInput",),
    "conrod.exact.kinematics": ("Kinematics",),
    "conrod.exact": ("GenericReference",),
    "conrod.mechanism.mechanism": ("Mechanism",),
    "conrod.runs.comparison": ("Comparison", "compare"),
    "conrod.runs.trajectory": ("Outcome", "Trajectory"),
    "conrod.scenes": ("SCENES", "CamFollower", "Saw", "Scene", "ShearPress"),
    "conrod.studies.frame.baseline": ("Drift", "Held"),
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
