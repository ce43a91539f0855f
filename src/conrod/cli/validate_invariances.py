"""`conrod validate --invariances`: what must not matter, of MuJoCo models and of the models of scenes."""

from __future__ import annotations

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

from rich.text import Text

from conrod.cli import FAILED, waiting
from conrod.cli.options import as_given
from conrod.cli.outputs import outputs
from conrod.cli.validate_request import MODELS, Request
from conrod.engines import engine_named
from conrod.errors import InvalidInput
from conrod.mechanism.units import check_number
from conrod.mjcf.results import Invariance, InvarianceStudy
from conrod.own.files import check_readable
from conrod.own.models.request import Controls, controls_of
from conrod.report.invariances import KIND, finding, invariances_table, notes
from conrod.report.terminal import console, print_lines, print_table
from conrod.scenes import Scene
from conrod.studies.execution.local import FILE_TIMEOUT, confined
from conrod.studies.frame.resolve_arguments import select_scenes
from conrod.studies.frame.writing import naming

TAKEN = ("--keyframe", "--seconds", "--ctrl", "--set", "--out", "--json", "--invariances")


def validate_invariances(asked: Request) -> None:
    """Study all subjects, print what was found, write what is to be written; raises InvalidInput for bad usage."""
    if other := next((name for name in as_given(asked) if name not in TAKEN), None):
        raise InvalidInput(f"{other} does not go with --invariances, which takes {', '.join(TAKEN[:-1])}")
    if asked.seconds is not None:
        check_number("--seconds", asked.seconds, 1e-9, 1e9, "s")
    models = [name for name in asked.subjects if name.lower().endswith(MODELS)]
    for name in models:
        check_readable(Path(name))
    names = [name for name in asked.subjects if name not in models]
    scenes = select_scenes(names, asked.assignments) if names or not models else {}
    files = outputs(KIND, [*(Path(name).stem for name in models), *scenes], asked)
    found = {}
    for name in models:
        with waiting(Path(name), FILE_TIMEOUT):
            found[Path(name).stem] = of_file(name, Path(name), asked, controls_of(asked.controls))
    for name, scene in scenes.items():
        found[name] = of_scene(name, scene, asked)
    with naming("standard output"):
        for study in found.values():
            _show(study)
    typed = dict(zip(found, [*models, *(names or scenes)], strict=True))
    files.write(found, "validate", typed, asked)
    if not all(study.passed for study in found.values()):
        sys.exit(FAILED)


def of_file(name: str, path: Path, asked: Request, controls: Controls) -> InvarianceStudy:
    """Invariances of a model file."""
    from conrod.mjcf.invariances.study import bits, study

    run = asked.seconds, asked.keyframe, controls
    words, found = confined(study, path, *run, confined(bits, path, *run))
    return InvarianceStudy(name, engine_named("mujoco").version, words, found)


def of_scene(name: str, scene: Scene, asked: Request) -> InvarianceStudy:
    """A scene's exported model, and its models in other orders of declaration."""
    from conrod.engines.mujoco.standalone import standalone_mjcf
    from conrod.mjcf.invariances.study import declared_otherwise

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"{name}.xml")
        path.write_text(standalone_mjcf(name, scene, None), encoding="utf-8")
        own = of_file(name, path, asked, ())
    orders = {one.change: one for one in declared_otherwise(scene)}
    return replace(own, found=tuple(_worse(one, orders.get(one.change)) for one in own.found))


def _worse(own: Invariance, orders: Invariance | None) -> Invariance:
    """The worse of an invariance of the scene's own model and of its models in other orders, which include it."""
    if orders is None or (own.over_bound or 0.0) > max(orders.over_bound or 0.0, 1.0):
        return own
    return orders


def _show(study: InvarianceStudy) -> None:
    out = console()
    print_lines(out, [Text(f"{study.name}: {finding(study)}", "green" if study.passed else "red")])
    print_table(out, invariances_table(study))
    print_lines(out, [*notes(study), ""])
