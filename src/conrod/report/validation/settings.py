"""The settings of every run, those that matter for the machine at hand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.table import Table, table
from conrod.report.validation.tables import dynamic
from conrod.studies.validation.results import SceneStudy, ValidationResult

MEANINGS = {
    "timestep": "time step [s]",
    "integrator": "integrator",
    "solver": "constraint solver",
    "iterations": "solver iterations, at most",
    "tolerance": "solver tolerance; the drive's armature forces 0",
    "solref": "loop closures: time constant [s], damping ratio",
    "solimp": "loop closures: impedance",
    "hardening": "factor on the compiled inverse weights, which scale the regularisation",
    "gravity": "gravity as in the real machine",
    "armature": "flywheel of the drive [kg m²]",
    "autoreset": "the engine may reset the state by itself",
    "contact_solref": "contact: time constant [s], damping ratio",
    "contact_solimp": "contact: impedance",
    "cam_vertices": "vertices of the cam's polygon, about",
    "error_bias": "share of a joint's error left after 1 s",
    "collision_bias": "share of a contact's error left after 1 s",
    "collision_slop": "overlap that contacts may keep [m]",
    "rod": "links with nothing but two pins: a body, or a distance joint",
    "refsafe": "a time constant below two steps is raised to them",
    "rounded_state": "the state is rounded to single precision after each step",
}
OF_CONTACT = {"contact_solref", "contact_solimp", "cam_vertices", "collision_bias", "collision_slop"}
OF_LOOPS = {"solref", "solimp", "hardening", "rod"}
NAMED_ELSEWHERE = {"preset", "steps_per_revolution"}


def settings_tables(study: SceneStudy, has_contact: bool) -> list[tuple[str, Table]]:
    """A heading and a table for each engine, with a column for each preset."""
    left_out = NAMED_ELSEWHERE | (OF_LOOPS if has_contact else OF_CONTACT)
    found = []
    for engine in dict.fromkeys(r.engine for r in dynamic(study)):
        runs = [r for r in dynamic(study) if r.engine == engine and r.settings is not None]
        if runs:
            found.append((f"{engine_title(engine)} {runs[0].engine_version}", _table(runs, left_out)))
    return found


def _table(runs: Sequence[ValidationResult], left_out: set[str]) -> Table:
    rows = [
        (f"`{name}`", MEANINGS.get(name, ""), *(_shown((run.settings or {}).get(name)) for run in runs))
        for name in runs[0].settings or {}
        if name not in left_out
    ]
    return table(["setting", "meaning", *(run.preset or "" for run in runs)], rows)


def _shown(value: Any) -> str:
    match value:
        case None:
            return "-"
        case bool():
            return "yes" if value else "no"
        case float():
            return numbers.quantity(value)
        case list() | tuple():
            return ", ".join(_shown(float(part)) for part in value)
        case _:
            return str(value)
