"""Imports go one way (docs/design.md), and what is light stays light."""

from __future__ import annotations

import ast
import inspect
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from import_graph import MODULES, ROOT, import_graph, imports, within

import conrod
from conrod.slices import SLICES

VERBS = [module.removeprefix("conrod.") for module in MODULES if module.endswith(".verb")]
# Modules of slices that draw.
DRAWINGS = (
    "models.tables.charts", "models.torque_runs.charts", "studies.free_motion.charts", "studies.limits.charts",
    "studies.limits.map_figure", "studies.limits.report", "studies.sweep.report", "studies.validation.charts",
    "models.tables.charts", "models.torque_runs.charts", "studies.free_motion.charts", "studies.limits.charts",
    "studies.limits.map_figure", "studies.limits.report", "studies.sweep.report", "studies.validation.charts",
    "studies.space.charts", "studies.validation.motion_chart", "studies.versions.report",
)  # fmt: skip

# The floors of the house, the lowest first: a room imports from its own floor and from those below (docs/design.md).
FLOORS = (
    "mechanism < exact < scenes, comparison < engines < execution < report < user_files < mjcf < studies < models < "
    "verification < guide < cli"
)
LEVEL = {room: level for level, rooms in enumerate(FLOORS.split(" < ")) for room in rooms.split(", ")}
AT_THE_ROOT = {"__init__", "__main__", "crash", "errors", "slices", "system", "testing"}

# Who may not import whom: (importers, imported, why). A name stands for a module and all below it.
FORBIDDEN = [
    ("conrod.engines", "conrod.scenes", "engines know no scene"),
    ("conrod.report", "conrod.engines.mujoco", "a saved study is rendered where no engine is installed"),
    ("conrod.report", "conrod.engines.pymunk", "a saved study is rendered where no engine is installed"),
    ("conrod.engines.mujoco", "conrod.engines.pymunk", "one engine a package"),
    ("conrod.engines.pymunk", "conrod.engines.mujoco", "one engine a package"),
    ("conrod.models.tables", "conrod.engines.mujoco", "a table is of any tool"),
    ("conrod.models.tables", "conrod.engines.pymunk", "a table is of any tool"),
    ("conrod.models.printed", "conrod.engines", "print is held against the exact motion, with no engine"),
    ("conrod", "audits", "the documents' audits are an application of conrod, not installed with it"),
    ("conrod.engines.mujoco.variants", "mujoco", "variations are of plain values"),
    ("conrod.engines.pymunk.variants", "pymunk", "grids and variations are of plain values"),
]

# Who alone may import a library, or the command line.
ALONE = {
    "mujoco": (
        "engines.mujoco",
        "engines.mjx",
        "mjcf",
        "models.check",
        "models.harden",
        "models.inspection",
        "models.invariances",
        "models.lint",
        "models.engine_comparison",
        "models.loops",
        "models.upgrades.release_calls",
        "user_files.in_memory",
    ),
    "pymunk": ("engines.pymunk",),
    "exudyn": ("engines.exudyn",),
    "jax": ("engines.mjx",),
    "pydrake": ("engines.drake",),
    "Box2D": ("engines.box2d",),
    "newton": ("engines.newton",),
    "warp": ("engines.newton",),
    "rapier3d": ("engines.rapier",),
    "matplotlib": ("report", *DRAWINGS),
    "distributed": ("execution.cluster",),
    "click": ("cli", *VERBS),
    "rich": ("cli", "report.terminal", "models.lint.verb"),
    "conrod.cli": ("cli", "__main__", *VERBS),
}


@pytest.mark.parametrize(
    ("importer", "imported", "why"), FORBIDDEN, ids=lambda value: str(value).removeprefix("conrod.")
)
def test_no_module_imports_what_is_forbidden_to_it(importer: str, imported: str, why: str) -> None:
    wrong = {
        module: [name for name in names if within(name, imported)]
        for module, names in import_graph().items()
        if within(module, importer)
    }
    assert not {module: names for module, names in wrong.items() if names}, why


def room(module: str) -> str:
    """The folder of a module; a verb stands on the floor of the command line, whichever folder it lies in."""
    if module.endswith(".verb"):
        return "cli"
    return module.split(".")[1] if "." in module else ""


def climbs(graph: dict[str, set[str]]) -> list[tuple[str, str]]:
    """Imports that go to a higher floor, or from a room to another on the same."""
    return [
        (module, name)
        for module, names in graph.items()
        for name in sorted(names)
        if room(module) in LEVEL and LEVEL.get(room(name), -1) >= LEVEL[room(module)] and room(name) != room(module)
    ]


def test_imports_go_down_the_floors() -> None:
    assert climbs(import_graph()) == []
    # Negative controls: an import upwards, and one between neighbours.
    assert climbs({"conrod.exact.jet": {"conrod.report.canvas"}}) == [("conrod.exact.jet", "conrod.report.canvas")]
    assert climbs({"conrod.comparison.outcome": {"conrod.scenes.scene"}}) == [
        ("conrod.comparison.outcome", "conrod.scenes.scene")
    ]


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "docs/design.md"])
def test_pages_name_the_floors_as_they_are_checked(page: str) -> None:
    words = " ".join((ROOT.parents[1] / page).read_text(encoding="utf-8").split())
    assert f"`{FLOORS}`" in words
    # Negative control: floors with a room of another name.
    assert f"`{FLOORS.replace('execution', 'runs')}`" not in words


def test_only_modules_of_no_room_lie_at_the_root() -> None:
    assert {path.stem for path in ROOT.glob("*.py")} == AT_THE_ROOT
    assert {path.name for path in ROOT.iterdir() if path.is_dir() and any(path.glob("*.py"))} <= {*LEVEL}


def test_no_two_modules_import_each_other() -> None:
    # An import in a function is allowed to go around; one at the top of two modules is a knot.
    packages = {module for module, path in MODULES.items() if path.name == "__init__.py"}
    graph = import_graph()
    knots = [(a, b) for a in graph for b in graph[a] if a in graph.get(b, set()) and a < b and not {a, b} & packages]
    assert knots == []


@pytest.mark.parametrize(
    ("name", "library"),
    [
        ("mujoco", "mujoco"),
        ("pymunk", "pymunk"),
        ("exudyn", "exudyn"),
        ("box2d", "Box2D"),
        ("mjx", "jax"),
        ("drake", "pydrake"),
        ("newton", "newton"),
        ("rapier", "rapier3d"),
    ],
)
def test_settings_of_an_engine_import_no_engine_library(name: str, library: str) -> None:
    # They stand in `__init__`, which is imported with every module of the package, be it only the translator.
    package = f"conrod.engines.{name}"
    assert [
        name for name in {package, *reachable_modules(package)} if any(within(n, library) for n in import_graph()[name])
    ] == []
    # Negative control: the engine is seen to import its library.
    assert any(within(name, library) for name in import_graph()[f"{package}.engine"])


@pytest.mark.parametrize("library", ALONE)
def test_library_is_imported_only_where_it_belongs(library: str) -> None:
    users = {module for module, names in import_graph().items() if any(within(name, library) for name in names)}
    assert users
    assert {m for m in users if not any(within(m, f"conrod.{place}") for place in ALONE[library])} == set()


def reachable_modules(start: str) -> set[str]:
    """Modules that a module imports, and those that these import, and so on."""
    found: set[str] = set()
    ahead = [start]
    while ahead:
        module = ahead.pop()
        if module not in found:
            found.add(module)
            ahead += [name for name in import_graph().get(module, ()) if name in MODULES]
    return found - {start}


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_studies_reach_an_engine_by_the_table_alone(engine: str) -> None:
    # The table names its modules in strings, which are imported when an engine is asked for.
    package = f"conrod.engines.{engine}"
    studies = [module for module in MODULES if within(module, "conrod.studies") and not module.endswith(".verb")]
    ways = {module: [name for name in reachable_modules(module) if within(name, package)] for module in studies}
    assert not {module: names for module, names in ways.items() if names}
    # Negative control: the walk does follow imports of imports.
    engine = f"{package}.engine"
    assert {name for name in reachable_modules(engine) - import_graph()[engine] if within(name, package)}


def engines_reached(start: str) -> set[str]:
    """Modules of MuJoCo's and pymunk's packages, and these libraries, that a module imports by whatever way."""
    libraries = ("mujoco", "pymunk", "conrod.engines.mujoco", "conrod.engines.pymunk")
    names = set[str]().union(*(import_graph()[module] for module in {start, *reachable_modules(start)}))
    return {name for name in names if any(within(name, library) for library in libraries)}


@pytest.mark.parametrize("place", [place for one in SLICES for place in sorted({*one.reports.values()})])
def test_saved_findings_are_rendered_without_an_engine(place: str) -> None:
    (report,) = {f"{one.package}.{place.rpartition('.')[0]}" for one in SLICES if place in one.reports.values()}
    assert engines_reached(report) == set()
    # Negative control: what runs models does reach one.
    assert engines_reached("conrod.models.check.study")


def test_the_walk_sees_every_kind_of_import(tmp_path: Path) -> None:
    # Negative control: an arrow hidden in a function, a branch or a submodule import is found.
    source = tmp_path / "saw.py"
    source.write_text(
        "def late():\n    from conrod.engines import engine_named\n"
        "try:\n    from conrod.engines import pymunk\nexcept ImportError:\n    import mujoco.viewer\n"
        "match 1:\n    case 1:\n        with open('x'):\n            import json.tool\n"
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import pymunk\n"
        "else:\n    Box2D = DeferredLibrary('Box2D')\n"
    )
    found = {"mujoco.viewer", "conrod.engines", "conrod.engines.pymunk", "json.tool", "typing", "Box2D"}
    assert imports(source) == found
    assert imports(source, type_checking=True) == {*found, "pymunk"}


def loaded_by(code: str) -> set[str]:
    """Modules that are loaded in a fresh interpreter after some code."""
    report = "import json; print('LOADED', json.dumps(sorted(sys.modules)))"
    script = f"import sys\ntry:\n    {code}\nexcept SystemExit:\n    pass\n{report}"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    line = next(line for line in done.stdout.splitlines() if line.startswith("LOADED"))
    return set(json.loads(line.removeprefix("LOADED")))


HEAVY = ("mujoco", "pymunk", "matplotlib", "numpy", "pint", "distributed", "dask", "pyarrow", "rich")
TOLD = (["--help"], ["--version"], ["validate", "--help"], ["show", "--help"])
LIGHT = {
    "import conrod": (*HEAVY, "importlib.metadata"),
    **{f"sys.argv = {['conrod', *words]!r}; from conrod.cli import main; main()": HEAVY for words in TOLD},
    "import conrod.execution.cluster, conrod.execution.local": ("distributed",),
    # A report is drawn without a window system.
    "import conrod.studies.validation.report, conrod.report.drawing.drawing": (
        "mujoco", "pymunk", "conrod.engines.mujoco", "conrod.engines.pymunk", "matplotlib.pyplot"
    ),
    "from conrod import Saw; from conrod.engines.mujoco.standalone import standalone_mjcf; "
    "standalone_mjcf('saw', Saw(), 1000)": ("mujoco",),
    # What reads finished runs needs the engines' versions alone.
    "import conrod; from conrod.engines import engine_named; [engine_named(e).version for e in ('mujoco', 'pymunk')]": (
        "mujoco", "pymunk", "conrod.engines.mujoco.model", "conrod.engines.pymunk.space", "conrod.engines.capabilities"
    ),
    # A file is judged in a process of its own, which alone loads what it takes.
    "import conrod.models.check.api, conrod.models.loops.api": ("mujoco", "scipy", "conrod.mjcf.driving"),
    "import conrod.cli.outputs": ("rich.progress",),
}  # fmt: skip


@pytest.mark.parametrize("code", LIGHT)
def test_light_code_loads_no_heavy_module(code: str) -> None:
    loaded = loaded_by(code)
    assert "conrod" in loaded
    assert [module for module in loaded if any(within(module, heavy) for heavy in LIGHT[code])] == []


def test_loaded_heavy_module_is_detected() -> None:
    # Negative control.
    assert {"numpy", "pymunk", "importlib.metadata"} <= loaded_by(
        "import conrod, pymunk; conrod.Saw, conrod.__version__"
    )


def test_public_names_do_not_depend_on_the_order_of_use() -> None:
    for names in (("compare", "run", "MuJoCoSettings"), ("MuJoCoSettings", "run", "compare")):
        lines = "; ".join(f"from conrod import {name}" for name in (*names, *names, "Saw"))
        code = f"{lines}; assert callable(run) and callable(compare), (run, compare); MuJoCoSettings.stock(Saw(), 100)"
        assert "conrod" in loaded_by(code)


def test_no_module_has_more_than_400_lines() -> None:
    long = [name for name, path in MODULES.items() if len(path.read_text(encoding="utf-8").splitlines()) > 400]
    assert long == []


# Files in which a function runs, from typing to the printed verdict: in the process that was typed, and in all.
# What a module makes when it is imported (an enumeration, a table of scenes) is no step of the way.
MOST_TYPED_FILES, MOST_FILES = 45, 79
# `sitecustomize` of the command and of its workers, which writes down each file when its first function is called.
COUNTING = """
import os, sys, threading
place, worker, known = os.environ["COUNTED"], "CONROD_WORKER" in os.environ, set()
def importing(frame):
    # The frame of conrod's module that is being imported, or None.
    while frame:
        if frame.f_code.co_name == "<module>" and frame.f_globals.get("__name__", "").startswith("conrod."):
            return frame
        frame = frame.f_back
def seen(frame, event, _):
    code = frame.f_code
    # A function: no body of a module or class, nor a comprehension, which is a call in some releases of Python alone.
    if event == "call" and code.co_filename not in known and code.co_flags & 1 and not code.co_name.endswith("comp>"):
        if f"{os.sep}conrod{os.sep}" not in code.co_filename:
            known.add(code.co_filename)
        elif not importing(frame):
            known.add(code.co_filename)
            with open(place, "a") as file:
                print("worker" if worker else "typed", code.co_filename, file=file)
threading.setprofile(seen)
sys.setprofile(seen)
"""


def test_a_validation_calls_functions_in_few_files(tmp_path: Path) -> None:
    (tmp_path / "sitecustomize.py").write_text(COUNTING)
    counted, path = tmp_path / "counted", os.pathsep.join([str(tmp_path), str(ROOT.parent)])
    command = ["-m", "conrod", "validate", "saw-500rpm", "--ledger", str(tmp_path / "l.sqlite")]
    counting = {**os.environ, "PYTHONPATH": path, "COUNTED": str(counted)}
    subprocess.run([sys.executable, *command], check=True, capture_output=True, env=counting)
    lines = {line for line in counted.read_text().splitlines() if line.partition(" ")[2].startswith(str(ROOT))}
    files = {line.partition(" ")[2] for line in lines}
    typed = {line.partition(" ")[2] for line in lines if line.startswith("typed")}
    # Negative control: of each process some files are seen that the other does not need.
    steps = {str(ROOT / name) for name in ("cli/outputs.py", "engines/mujoco/dynamics.py", "engines/pymunk/space.py")}
    assert steps <= files
    assert steps & typed == {str(ROOT / "cli/outputs.py")}
    assert len(typed) <= MOST_TYPED_FILES, sorted(typed)
    assert len(files) <= MOST_FILES, sorted(files - typed)


# -- what `import conrod` shows is public, and all of it ---------------------------------------------------------------


def test_dir_and_help_show_exactly_the_public_names() -> None:
    assert dir(conrod) == sorted(conrod.__all__)
    assert {"SCENES", "compare", "run"} <= set(dir(conrod))
    shown = dict(inspect.getmembers(conrod))
    assert all(shown[name] is getattr(conrod, name) for name in conrod.__all__)


def test_type_checkers_see_the_same_names() -> None:
    tree = ast.parse(Path(conrod.__file__).read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING")
    typed = {f"{node.module}.{a.asname}" for node in block.body if isinstance(node, ast.ImportFrom) for a in node.names}
    assert typed == {f"{module}.{name}" for name, module in conrod._HOMES.items()}


def test_unknown_name_is_answered_with_the_public_names() -> None:
    with pytest.raises(AttributeError, match=r"no attribute 'Simulate'; it has .*compare, .*run"):
        _ = conrod.Simulate  # type: ignore[attr-defined]  # that is the mistake
