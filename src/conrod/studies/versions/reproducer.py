"""A script that shows a change between two releases of an engine: run in both before it is handed on."""

from __future__ import annotations

import subprocess
from collections.abc import Sequence

from conrod.engines import Engine
from conrod.engines.capabilities import Reproduces, required
from conrod.errors import InvalidInput
from conrod.studies.versions.environment import Environments
from conrod.studies.versions.findings import VersionStudy
from conrod.studies.versions.study import Probe

HEADER = '''# /// script
# requires-python = ">=3.11"
# dependencies = ["{requirement}", "numpy"]
# ///
"""{title}

With "{earlier}" in the third line it is the release before. It printed

{printed}
"""
'''
PATIENCE = 600.0  # [s]


def reproducer(study: VersionStudy, probes: Sequence[Probe], engine: Engine, environments: Environments) -> str:  # type: ignore[type-arg]
    """The script of the study's largest change: of another outcome before one that moved the machine most.

    Raises:
        InvalidInput: nothing changed, the engine cannot be had as a script, or the script alone shows no change.
    """
    made, changes = required(engine, Reproduces), [c for v in study.measured for c in study.changes_at(v)]
    if not changes:
        raise InvalidInput("--reproducer: no release changed a bit of these runs")
    history, change = max(changes, key=lambda each: (not each[1].size, each[1].size.get("position", 0.0)))
    probe = next(one for one in probes if (one.name, one.settings) == (history.scene, history.settings))
    case, versions = probe.path[-1], (change.before, change.version)
    script = made.reproducer(case.scene, case.settings, versions, case.revolutions, case.start_angle)
    requirements = [made.releases.requirement(version) for version in versions]
    printed = [
        _printed(environments.interpreter(engine.name, requirement, version), script)
        for requirement, version in zip(requirements, versions, strict=True)
    ]
    if printed[0].partition("\n")[2] == printed[1].partition("\n")[2]:
        raise InvalidInput(f"--reproducer: {history.scene}, {history.settings}: the change is not in the run alone")
    title = f"{history.scene}, {history.settings}, in {engine.name} {versions[0]} and {versions[1]}."
    return (
        HEADER.format(earlier=requirements[0], requirement=requirements[1], title=title, printed="\n".join(printed))
        + script
    )


def _printed(interpreter: str, script: str) -> str:
    try:
        command = [interpreter, "-I", "-"]
        done = subprocess.run(command, input=script, capture_output=True, text=True, timeout=PATIENCE, check=True)
    except (OSError, subprocess.SubprocessError) as error:
        raise InvalidInput(f"--reproducer: the script does not run there: {' '.join(str(error).split())}") from None
    return done.stdout
