"""`conrod validate --invariances`: what must not matter, of MuJoCo models and of the models of scenes."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from conrod.cli import waiting
from conrod.cli.options import refuse_others
from conrod.cli.validate_request import MODELS, Judging, Request
from conrod.engines import engine_named
from conrod.errors import InvalidInput
from conrod.mechanism.units import check_number
from conrod.mjcf.results import Invariance, InvarianceStudy
from conrod.own.files import as_outputs_must_not_be, check_readable
from conrod.own.models.request import Controls, controls_of
from conrod.report.invariances import KIND, finding, invariances_table, notes
from conrod.report.terminal import Part, said
from conrod.scenes import Scene
from conrod.studies.execution.local import FILE_TIMEOUT, confined
from conrod.studies.frame.resolve_arguments import select_scenes

TAKEN = ("--keyframe", "--seconds", "--ctrl", "--set", "--out", "--html", "--json", "--invariances")


def judging(asked: Request) -> Judging:
    """Invariances of all subjects; raises InvalidInput for bad usage."""
    refuse_others(asked, "--invariances", *TAKEN)
    if asked.seconds is not None:
        check_number("--seconds", asked.seconds, 1e-9, 1e9, "s")
    models = [name for name in asked.subjects if name.lower().endswith(MODELS)]
    inputs = dict[str, Path]()
    for name in models:
        check_readable(Path(name))
        inputs |= as_outputs_must_not_be(Path(name))
    controls, named = controls_of(asked.controls), [name for name in asked.subjects if name not in models]
    scenes = select_scenes(named, asked.assignments) if named or not models else {}

    def judge(_: Request, others: Sequence[Mapping[str, Scene]]) -> list[list[InvarianceStudy]]:
        found = []
        for name in models:
            with waiting(Path(name), FILE_TIMEOUT):
                found.append(of_file(name, Path(name), asked, controls))
        return [[*found, *(of_scene(name, scene, asked) for name, scene in one.items())] for one in others]

    parts = [*(Path(name).stem for name in models), *scenes]
    if hidden := next((name for k, name in enumerate([*models, *scenes]) if parts[k] in parts[:k]), None):
        raise InvalidInput(f"{hidden}: another has the same name in the report: judge it by itself")
    typed = dict(zip(parts, [*models, *(named or scenes)], strict=True))
    return Judging(KIND, typed, parts, judge, invariances_found, finding, scenes, inputs)


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


def invariances_found(studies: Sequence[InvarianceStudy]) -> Iterator[Part]:
    """Of each model the finding, what was changed, and notes."""
    for study in studies:
        yield said(f"{study.name}: {finding(study)}", study.passed)
        yield invariances_table(study)
        yield from (*notes(study), "")
