"""Changes that must not matter: of MuJoCo models, and of the models of scenes."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from conrod.engines import engine_named
from conrod.errors import InvalidInput
from conrod.execution.local import call_on_file
from conrod.execution.resolve_arguments import OneScene, is_single_scene, scenes_by_name
from conrod.mechanism.units import check_number
from conrod.mjcf.request import Controls, controls_of
from conrod.models.invariances.report import INVARIANCES_REPORT
from conrod.models.invariances.results import Invariance, InvarianceStudy
from conrod.report.findings import Findings, text_of_call
from conrod.scenes import Scene
from conrod.user_files import MODELS
from conrod.user_files.files import check_readable
from conrod.user_files.in_memory import file_of_model

if TYPE_CHECKING:
    import mujoco

SHORTEST_RUN, LONGEST_RUN = 1e-9, 1e9  # [s]


def invariances(
    subjects: OneScene | mujoco.MjModel | mujoco.MjSpec | Sequence[OneScene] | Mapping[str, Scene] = (),
    *,
    keyframe: str | None = None,
    controls: Mapping[str, float] | None = None,
    seconds: float | None = None,
    progress: Callable[[str], object] = lambda name: None,
) -> Findings[InvarianceStudy]:
    """Change what must not matter in MuJoCo models, and compare the accelerations.

    Args:
        subjects: model files, models in memory, or scenes; the four with a closed form where none is given.
        keyframe, controls: as in `check_model`, for files.
        seconds: length of the run from which states are taken [s].
        progress: called with the name of each model file before it is run.

    Raises:
        InvalidInput: a subject or an argument cannot be used; says what can.
    """
    if seconds is not None:
        check_number("--seconds", seconds, SHORTEST_RUN, LONGEST_RUN, "s")
    inputs = controls_of(controls or {})
    if isinstance(subjects, Mapping) or not isinstance(subjects, Sequence) or is_single_scene(subjects):
        subjects = list(subjects.items()) if isinstance(subjects, Mapping) else [subjects]
    models = [one for one in subjects if is_model(one)]
    named = [one for one in subjects if not is_model(one)]
    scenes = scenes_by_name(named) if named or not models else {}
    found, typed = dict[str, InvarianceStudy](), dict[str, str]()
    for model in models:
        with file_of_model(model) as (path, shown):
            check_readable(path)
            progress(shown or str(model))
            part = shown or path.stem
            _check_free(part, str(model), found)
            found[part] = invariances_of_file(shown or str(model), path, seconds, keyframe, inputs)
            typed[part] = str(model)
    for name, scene in scenes.items():
        _check_free(name, name, found)
        found[name] = invariances_of_scene(name, scene, seconds, keyframe)
    asked = [*(str(one) if isinstance(one, str | Path) else "the model" for one in models), *scenes]
    call = text_of_call("invariances", asked, keyframe=keyframe, controls=controls, seconds=seconds)
    return Findings(INVARIANCES_REPORT, found, call, typed=typed)


def is_model(subject: Any) -> bool:
    """True for a model, in memory or as a file; False for a scene."""
    if isinstance(subject, Scene | tuple):
        return False
    return not isinstance(subject, str | Path) or str(subject).lower().endswith(MODELS)


def _check_free(part: str, name: str, found: Mapping[str, InvarianceStudy]) -> None:
    if part in found:
        raise InvalidInput(f"{name}: another has the same name in the report: judge it by itself")


def invariances_of_file(
    name: str, path: Path, seconds: float | None, keyframe: str | None, controls: Controls
) -> InvarianceStudy:
    """Invariances of a model file, found in another process."""
    from conrod.models.invariances.study import states_digest, study_invariances

    run = seconds, keyframe, controls
    words, found = call_on_file(study_invariances, path, *run, call_on_file(states_digest, path, *run))
    return InvarianceStudy(name, engine_named("mujoco").version, words, found)


def invariances_of_scene(
    name: str, scene: Scene, seconds: float | None = None, keyframe: str | None = None
) -> InvarianceStudy:
    """Invariances of a scene's exported model, and of its models in other orders of declaration."""
    from conrod.engines.mujoco.standalone import standalone_mjcf
    from conrod.models.invariances.study import study_declaration_orders

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"{name}.xml")
        path.write_text(standalone_mjcf(name, scene, None), encoding="utf-8", newline="\n")
        own = invariances_of_file(name, path, seconds, keyframe, ())
    orders = {one.change: one for one in study_declaration_orders(scene)}
    return replace(own, found=tuple(_worse(one, orders.get(one.change)) for one in own.found))


def _worse(own: Invariance, orders: Invariance | None) -> Invariance:
    """The worse of an invariance of the scene's own model and of its models in other orders, which include it."""
    if orders is None or (own.over_bound or 0.0) > max(orders.over_bound or 0.0, 1.0):
        return own
    return orders
