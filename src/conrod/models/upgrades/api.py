"""What an upgrade of MuJoCo changes in a user's own model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from conrod.engines import engine_named
from conrod.engines.capabilities import KnownReleases, require_capability
from conrod.errors import InvalidInput, as_names
from conrod.execution.local import FILE_TIMEOUT
from conrod.execution.releases import ReleaseProcesses
from conrod.mechanism.units import check_number
from conrod.mjcf.request import controls_of
from conrod.models.upgrades.report import UPGRADES_REPORT
from conrod.models.upgrades.results import ModelRun, UpgradeStudy
from conrod.models.upgrades.study import call_release, model_costs, upgrade_study
from conrod.report.findings import Findings, text_of_call
from conrod.user_files.files import check_readable

SECONDS, SHORTEST_RUN, LONGEST_RUN = 2.0, 1e-6, 1e6  # [s]


def compare_releases(
    models: str | Path | Sequence[str | Path],
    *,
    releases: str | Sequence[str] | None = None,
    keyframe: str | None = None,
    controls: Mapping[str, float] | None = None,
    seconds: float = SECONDS,
    costs: bool = False,
    progress: Callable[[str], object] = lambda name: None,
) -> Findings[UpgradeStudy]:
    """Run a model of your own as its file has it in several releases of MuJoCo, and name what changed.

    Args:
        models: paths of MJCF files.
        releases: such as ("3.17.0", "4.0.0"), all that conrod knows where none is given.
        keyframe: keyframe to start from; None for the first, or the model's own pose without any.
        controls: inputs of actuators, by name; the keyframe's where none is given.
        seconds: length of the run [s].
        costs: time the steps too, each release in turns with the installed one, or with the first.
        progress: called with the name of each model before it is run.

    Raises:
        InvalidInput: a model or an argument cannot be used, or no release runs the model.
    """
    check_number("--seconds", seconds, SHORTEST_RUN, LONGEST_RUN, "s")
    made = engine_named("mujoco")
    known = require_capability(made, KnownReleases).releases
    versions = known.select_versions(None if releases is None else ",".join(as_names(releases)))
    several = [models] if isinstance(models, str | Path) else list(models)
    found, typed = dict[str, UpgradeStudy](), dict[str, str]()
    for one in several:
        path = Path(one)
        check_readable(path)
        if path.suffix.lower() == ".mjb":
            raise InvalidInput(f"{path}: a compiled model is of one release alone: give the XML that it was made of")
        if path.stem in found:
            raise InvalidInput(f"{path}: another has the same name in the report: judge it by itself")
        progress(str(path))
        request = ModelRun(str(path.absolute()), keyframe, controls_of(controls or {}), seconds)
        with ReleaseProcesses(made.name, known.requirement, FILE_TIMEOUT) as processes:
            call = partial(call_release, processes)
            study = upgrade_study(path.name, request, versions, known, call)
            if costs:
                reference = made.version if made.version in study.measured else study.measured[0]
                timed = model_costs(study, request, reference, call)
                study = replace(study, reference=reference, costs=timed)
        found[path.stem], typed[path.stem] = study, str(path)
    again = text_of_call(
        "compare_releases", [str(one) for one in several], releases=releases, keyframe=keyframe, controls=controls,
        seconds=None if seconds == SECONDS else seconds, costs=costs or None,
    )  # fmt: skip
    return Findings(UPGRADES_REPORT, found, again, typed=typed)
