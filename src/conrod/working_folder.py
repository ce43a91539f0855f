"""Keep the working folder off the import path of `python -m conrod`."""

import os
import sys

# Environment of all that conrod starts, and that libraries start there: MuJoCo, where something is to be drawn, loads
# GLFW, which has an interpreter of its own look at a library.
SAFE_PATH = {"PYTHONSAFEPATH": "1", "MUJOCO_GL": "disable"}
# Threads of linear algebra, unless the user asks for others. Matrices are small and processes many: more would get in
# each other's way, and last digits depend on the number of cores.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}


def leave_working_folder() -> None:
    """Drop the folder that `python -m` put in front of Python's own library.

    A `csv.py` beside a user's model is data to conrod. To be called before anything else is imported: this module has
    no `from __future__` either, which is a file too. A folder that conrod itself came from stays.
    """
    if not _runs_conrod() or sys.flags.safe_path:
        return
    home = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    try:
        folder = os.getcwd()
    except FileNotFoundError:  # it has been removed, and is not on the path
        return
    if sys.path[:1] == [folder] and folder != home:
        del sys.path[0]


def _runs_conrod() -> bool:
    """True if this is `python -m conrod`, which is no longer visible once the package is imported."""
    if sys.argv[:1] != ["-m"]:
        return False
    # In front of the arguments: conrod, or -mconrod, perhaps with other options in the same word.
    module = sys.orig_argv[-len(sys.argv)]
    return module == "conrod" or (module.startswith("-") and module.endswith("mconrod"))
