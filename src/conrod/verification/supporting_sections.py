"""Sections of a verification report that need more than its study: inputs, software, parameters, measurements."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from conrod.engines import engine_packages, environment
from conrod.errors import InvalidInput
from conrod.models.check.references import sensitivities, uncertainty_shares
from conrod.models.check.results import ModelStudy
from conrod.models.invariances import report as invariances
from conrod.models.invariances.results import InvarianceStudy
from conrod.models.tables import report as trajectory
from conrod.models.tables.study import TableStudy
from conrod.report import numbers
from conrod.report.results import parameters_table, scene_description
from conrod.report.table import table
from conrod.scenes import Scene
from conrod.studies.limits.results import LimitStudy
from conrod.studies.limits.tables import limits_table
from conrod.user_files.files import package_hash, sha256, stated_source
from conrod.verification.page import VerificationSection

EXAMPLE_UNCERTAINTY = 1e-3  # standard uncertainty of a length where none is given, as a share of the length
MEASUREMENTS = "measured"  # name of the measurements among uncertainties
COVERAGE_FACTOR = 2.0  # standard uncertainties that cover an error, about 95 %


def inputs_section(files: Sequence[Path], scene: Scene | None) -> VerificationSection:
    """Return the section on input files: SHA-256 and stated source of each."""
    contents = [(path.name, path.read_bytes()) for path in files]
    rows = [(name, sha256(content), stated_source(content) or "not stated") for name, content in contents]
    if scene is not None:
        rows.append((f"parameters of {scene.kind}", sha256(scene.parameters_text.encode()), scene.source))
    return VerificationSection((table(("input", "SHA-256", "stated source"), rows),))


def machine_section(scene: Scene, changed: Sequence[str]) -> VerificationSection:
    """Return the section on the machine: title, drawing, speed, and all parameters with masses.

    Args:
        scene: the machine.
        changed: parameters that the user gave, as typed: `crank=80mm`.
    """
    speed = " ".join(numbers.in_shown_unit(scene.speed, "rad/s"))
    other = f", with {', '.join(changed)}" if changed else ""
    words = (f"{scene.title} at {speed}{other}.", scene_description(scene))
    return VerificationSection((parameters_table(scene),), tuple(dict.fromkeys(words)))


def software_section(study: Any) -> VerificationSection:
    """Return the section on software: packages with hashes, and the platform."""
    runs_fmu = isinstance(study, TableStudy) and study.form.startswith("FMI")
    used = ("conrod", *engine_packages(), *(["FMPy"] if runs_fmu else []), "numpy", "scipy")
    rows = [(name, *package_hash(name)) for name in used]
    where = [f"{name} {value}" for name, value in environment().items() if name in ("python", "machine", "system")]
    return VerificationSection((table(("package", "version", "SHA-256", "of its"), rows),), (", ".join(where),))


def parameters_section(
    scene: Scene | None, given: Mapping[str, float], off: Mapping[str, float]
) -> tuple[VerificationSection, list[str], float | None]:
    """Return the section on uncertain lengths, open deviations, and the uncertainty of places.

    Args:
        scene: the machine; None for a model without one.
        given: standard uncertainties of lengths [m].
        off: deviations of the model's lengths [m].

    Returns:
        The section; open deviations; standard uncertainty of a point's position [m], None if `given` is empty.
    """
    if scene is None:
        return (
            VerificationSection((), ("does not apply: a model that is its own reference has no lengths with names",)),
            [],
            None,
        )
    try:
        slopes = sensitivities(scene)
    except InvalidInput as error:
        return (
            VerificationSection((), (f"does not apply: with one length changed alone it is no machine ({error})",)),
            [],
            None,
        )
    sizes = given or {name: EXAMPLE_UNCERTAINTY * abs(scene.parameters[name]) for name in slopes}
    together, parts = uncertainty_shares(slopes, sizes)
    rows = [
        (
            name, numbers.quantity(1e3 * scene.parameters[name], 9), numbers.quantity(float(slope.max()), 3),
            numbers.quantity(1e3 * sizes.get(name, 0.0), 3), numbers.percent(parts[name]),
        )
        for name, slope in slopes.items()
    ]  # fmt: skip
    head = ("value [mm]", "sensitivity [mm/mm]", "standard uncertainty [mm]", "share")
    example = "no uncertainties were given (`--uncertainty NAME=SIZE`): 0.1 % of each length stands in their place"
    words = f"together they move a point by {_mm_text(together)}, a standard uncertainty, where that is largest"
    found = VerificationSection((table(("length", *head), rows, head),), (words, *(() if given else (example,))))
    moves = [
        f"{name} of the model is off by {_mm_text(by)}: by its sensitivity that moves a point by up to "
        f"{_mm_text(abs(by) * float(slopes[name].max()))}"
        for name, by in off.items()
    ]
    return found, moves, together if given else None


def validation_section(
    study: Any, found: TableStudy | None, parts: tuple[float | None, float | None]
) -> tuple[VerificationSection, list[str]]:
    """Return the section on validation by ASME V&V 20, and open deviations.

    The comparison error E is the largest distance of measured from exact positions [m]. The validation uncertainty is
    u_val = sqrt(u_num^2 + u_input^2 + u_D^2); an error of the model stands out if E > 2 u_val.

    Args:
        study: validation of the model, which gives u_num.
        found: measurements compared with the exact motion; None where there are none.
        parts: u_input and u_D [m]; None where not known.
    """
    if found is None:
        return VerificationSection(
            (), ("validation not performed: no measurements were given as a table (`--measured`)",)
        ), []
    lengths = found.scene.lengths
    places = [(point, curves.get("position", curves.get("total"))) for point, curves in found.errors.items()]
    error = max((curve.size.max * lengths[point] for point, curve in places if curve), default=None)
    if error is None:
        return VerificationSection((), ("validation not performed: the measurements have no positions",)), []
    sizes = {
        "u_num, the numerical error of the judged runs": _numerical_error(study) * max(lengths.values()),
        "u_input, by the parameters": parts[0],
        "u_D, of the measurements": parts[1],
    }
    words = [trajectory.summary_line(found), *trajectory.estimation_lines(found), *found.notes]
    words.append(f"comparison error E of measured and exact places, at most: {_mm_text(error)}")
    words += [f"{name}: {'not given (--uncertainty)' if u is None else _mm_text(u)}" for name, u in sizes.items()]
    if None in parts:
        words.append("without both no validation uncertainty can be stated: E alone says nothing on the model")
        return VerificationSection((), tuple(words)), []
    whole = math.hypot(*(size for size in sizes.values() if size is not None))
    beyond = error > COVERAGE_FACTOR * whole
    relation, stands = ("more than", "stands") if beyond else ("within", "does not stand")
    verdict = f"E is {relation} twice the validation uncertainty u_val of {_mm_text(whole)}"
    return VerificationSection((), (*words, f"{verdict}: an error of the model {stands} out")), [
        verdict
    ] if beyond else []


def _numerical_error(study: Any) -> float:
    """Return the largest position error of the judged runs, over L."""
    if isinstance(study, ModelStudy):
        return 0.0 if study.driven_run is None else study.driven_run.worst("position") or 0.0
    return max((r.largest("position") or 0.0 for r in getattr(study, "results", ()) if r.limits), default=0.0)


def validity_section(study: LimitStudy | None, scene: Scene | None) -> tuple[VerificationSection, list[str]]:
    """Return the section on the domain of validity from `conrod limits`, and open deviations."""
    if study is None or scene is None:
        return VerificationSection((), ("missing: no results of `conrod limits` were given (`--limits DIR`)",)), []
    engines = ", ".join(f"{name} {version}" for name, version in study.engines.items())
    others = dict(study.parameters) != dict(scene.parameters)
    off = ["the domain of validity was found with other parameters"] if others else []
    return VerificationSection((limits_table(study.walks),), (f"found with {engines}",)), off


def invariances_section(study: InvarianceStudy | str) -> tuple[VerificationSection, list[str]]:
    """Return the section on invariances, and open deviations."""
    if isinstance(study, str):
        return VerificationSection((), (f"missing: {study}",)), []
    words = invariances.finding(study)
    return VerificationSection((invariances.invariances_table(study),), (words,)), [] if study.passed else [words]


def _mm_text(size: float) -> str:
    return f"{numbers.scaled_text(size, 1e3)} mm"
