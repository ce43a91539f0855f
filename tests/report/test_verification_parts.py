"""Sections of a verification report on inputs, software, lengths, measurements, domain of validity and invariances."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import handmade_studies as made
import numpy as np
import pytest
from handmade_studies import SCENE, curve, loop_study, model_study, scene_study, table_study

from conrod.errors import InvalidInput
from conrod.models.invariances.results import Invariance, InvarianceOutcome, InvarianceStudy
from conrod.models.tables.estimation import Estimate
from conrod.report.table import Table
from conrod.scenes import Saw
from conrod.studies.limits.results import Boundary, LimitStudy, Probe, Walk
from conrod.verification import supporting_sections as parts
from conrod.verification.page import VerificationSection


def test_inputs_have_their_hash_and_the_source_that_they_state(tmp_path: Path) -> None:
    stated, silent = tmp_path / "a.xml", tmp_path / "b.csv"
    stated.write_bytes(b"<!-- drawn by hand -->\n<mujoco/>\n")
    silent.write_bytes(b"t,x\n")
    hashes = [
        hashlib.sha256(text).hexdigest() for text in (stated.read_bytes(), b"t,x\n", SCENE.parameters_text.encode())
    ]
    head = ("input", "SHA-256", "stated source")
    rows = (("a.xml", hashes[0], "drawn by hand"), ("b.csv", hashes[1], "not stated"))
    own = ("parameters of saw", hashes[2], SCENE.source)
    assert parts.inputs_section([stated, silent], None) == VerificationSection((Table(head, rows),))
    assert parts.inputs_section([stated, silent], SCENE) == VerificationSection((Table(head, (*rows, own)),))


@pytest.mark.parametrize(
    ("study", "runs_fmu"),
    [
        (table_study(form="FMI 2.0 co-simulation"), True),
        (table_study(), False),
        (scene_study(), False),
    ],
    ids=["an FMU", "a table", "a scene"],
)
def test_software_lists_packages_and_platform(study: Any, runs_fmu: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "engine_packages", lambda: ("mujoco", "pymunk"))
    monkeypatch.setattr(parts, "package_hash", lambda name: (f"{name} 1", f"hash of {name}", f"files of {name}"))
    platform = {"python": "3.11.9", "machine": "x86_64", "system": "Linux", "mujoco": "9.1"}
    monkeypatch.setattr(parts, "environment", lambda: platform)
    used = ("conrod", "mujoco", "pymunk", *(["FMPy"] if runs_fmu else []), "numpy", "scipy")
    rows = tuple((name, f"{name} 1", f"hash of {name}", f"files of {name}") for name in used)
    assert parts.software_section(study) == VerificationSection(
        (Table(("package", "version", "SHA-256", "of its"), rows),), ("python 3.11.9, machine x86_64, system Linux",)
    )


# -- lengths -----------------------------------------------------------------------------------------------------------

LENGTHS_HEAD = ("length", "value [mm]", "sensitivity [mm/mm]", "standard uncertainty [mm]", "share")
BELOW = Saw(crank=0.1, rod=0.3, offset=-0.05)  # a slide below the shaft: a length may be negative


def lengths_table(*rows: tuple[str, ...]) -> Table:
    return Table(LENGTHS_HEAD, rows, frozenset(LENGTHS_HEAD[1:]))


@pytest.fixture
def slopes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sensitivities [m/m] of one point at two crank angles."""
    found = {"crank": np.array([[1.0, 2.0]]), "rod": np.array([[0.5, 1.5]]), "offset": np.array([[0.4, 0.1]])}
    monkeypatch.setattr(parts, "sensitivities", lambda scene: found if scene is BELOW else {})


@pytest.mark.usefixtures("slopes")
def test_length_uncertainties_combine_at_their_largest_effect() -> None:
    found, deviations, together = parts.parameters_section(BELOW, {"crank": 3e-4, "rod": 2e-4}, {"rod": -3e-4})
    # At the second angle: (2 * 0.3 mm)^2 + (1.5 * 0.2 mm)^2 = 0.45 mm^2, of which the crank's is 0.36 mm^2.
    assert together == pytest.approx(np.sqrt(0.45e-6))
    table = lengths_table(
        ("crank", "100", "2", "0.3", "80 %"), ("rod", "300", "1.5", "0.2", "20 %"), ("offset", "-50", "0.4", "0", "0 %")
    )
    words = "together they move a point by 0.67 mm, a standard uncertainty, where that is largest"
    assert found == VerificationSection((table,), (words,))
    assert deviations == ["rod of the model is off by -0.30 mm: by its sensitivity that moves a point by up to 0.45 mm"]


@pytest.mark.usefixtures("slopes")
def test_lengths_without_uncertainty_count_with_a_thousandth() -> None:
    found, deviations, together = parts.parameters_section(BELOW, {}, {})
    # (1.5 * 0.3 mm)^2 + (2 * 0.1 mm)^2 + (0.1 * 0.05 mm)^2 = 0.242525 mm^2.
    table = lengths_table(
        ("crank", "100", "2", "0.1", "16 %"), ("rod", "300", "1.5", "0.3", "83 %"),
        ("offset", "-50", "0.4", "0.05", "< 1 %"),
    )  # fmt: skip
    assert found == VerificationSection(
        (table,),
        (
            "together they move a point by 0.49 mm, a standard uncertainty, where that is largest",
            "no uncertainties were given (`--uncertainty NAME=SIZE`): 0.1 % of each length stands in their place",
        ),
    )
    assert (deviations, together) == ([], None)


def test_lengths_have_nine_digits_and_sensitivities_three(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "sensitivities", lambda scene: {"crank": np.array([[1.23456]])})
    found, _, together = parts.parameters_section(Saw(crank=0.12345678912), {"crank": 1.23456e-4}, {})
    assert found.tables == (lengths_table(("crank", "123.456789", "1.23", "0.123", "100 %")),)
    assert together == pytest.approx(1.23456 * 1.23456e-4)


def test_uncertainties_do_not_apply_without_lengths(monkeypatch: pytest.MonkeyPatch) -> None:
    words = "does not apply: a model that is its own reference has no lengths with names"
    assert parts.parameters_section(None, {"rod": 1e-4}, {"rod": 1e-4}) == (VerificationSection((), (words,)), [], None)

    def refuse(scene: Any) -> Any:
        raise InvalidInput("it cannot turn")

    monkeypatch.setattr(parts, "sensitivities", refuse)
    words = "does not apply: with one length changed alone it is no machine (it cannot turn)"
    assert parts.parameters_section(BELOW, {"rod": 1e-4}, {"rod": 1e-4}) == (
        VerificationSection((), (words,)), [], None,
    )  # fmt: skip


# -- measurements ------------------------------------------------------------------------------------------------------

MEASURED = table_study(estimates=(Estimate("time", 2e-3, 1e-4, 1e-3),))
FIRST_WORDS = (
    "t.csv: 7 rows, 0 to 4.5 s, 3 revolutions of saw (text, separated by commas, decimal points)",
    "time, the table's clock minus the scene's: 2 ms, standard error 0.10 ms; what is left is 0.0010 (0.20 mm) rms",
    "a note",
    # Of 2e-3 L at the angle that the table says, not of 4e-3 L at the nominal time; L is 0.2 m.
    "comparison error E of measured and exact places, at most: 0.40 mm",
)


def judged_scene() -> Any:
    """A judged run that is off by 1.6e-4 L = 0.032 mm, and one without limits that is off by far more."""
    judged = made.with_tolerance(made.validation_result("tuned"), "laws", position=1e-3)
    far = {"C": {"position": made.sizes(0.1)}}
    return scene_study(judged, made.validation_result("stock", errors=far))


@pytest.mark.parametrize(
    ("measurements", "shown", "words", "off"),
    [
        # sqrt(0.032^2 + 0.12^2 + 0.16^2) mm is 0.2025 mm, and twice that is more than 0.4 mm.
        (1.6e-4, "0.16", "E is within twice the validation uncertainty u_val of 0.20 mm", False),
        # sqrt(0.032^2 + 0.12^2 + 0.15^2) mm is 0.1947 mm, and twice that is less.
        (1.5e-4, "0.15", "E is more than twice the validation uncertainty u_val of 0.19 mm", True),
    ],
)
def test_error_beyond_twice_validation_uncertainty_stands_out(
    measurements: float, shown: str, words: str, off: bool
) -> None:
    found, deviations = parts.validation_section(judged_scene(), MEASURED, (1.2e-4, measurements))
    assert found == VerificationSection(
        (),
        (
            *FIRST_WORDS,
            "u_num, the numerical error of the judged runs: 0.032 mm",
            "u_input, by the parameters: 0.12 mm",
            f"u_D, of the measurements: {shown} mm",
            f"{words}: an error of the model {'stands' if off else 'does not stand'} out",
        ),
    )
    assert deviations == ([words] if off else [])


@pytest.mark.parametrize("known", [(1.2e-4, None), (None, 1.6e-4)])
def test_error_says_nothing_without_a_part_of_the_uncertainty(known: tuple[float | None, float | None]) -> None:
    found, deviations = parts.validation_section(judged_scene(), MEASURED, known)
    given = ("0.12 mm", "not given (--uncertainty)") if known[1] is None else ("not given (--uncertainty)", "0.16 mm")
    assert found == VerificationSection(
        (),
        (
            *FIRST_WORDS,
            "u_num, the numerical error of the judged runs: 0.032 mm",
            f"u_input, by the parameters: {given[0]}",
            f"u_D, of the measurements: {given[1]}",
            "without both no validation uncertainty can be stated: E alone says nothing on the model",
        ),
    )
    assert deviations == []


def test_validation_needs_measured_positions() -> None:
    words = "validation not performed: no measurements were given as a table (`--measured`)"
    assert parts.validation_section(judged_scene(), None, (1e-4, 1e-4)) == (VerificationSection((), (words,)), [])
    rates = replace(MEASURED, errors={"C": {"velocity": curve(1e-3)}})
    words = "validation not performed: the measurements have no positions"
    assert parts.validation_section(judged_scene(), rates, (1e-4, 1e-4)) == (VerificationSection((), (words,)), [])


def test_comparison_error_is_the_largest_over_all_points() -> None:
    # Without a crank angle of its own a table has positions at the nominal time alone.
    scene = Saw()
    errors = {"C": {"total": curve(1e-3)}, "M": {"total": curve(2e-3), "velocity": curve(1.0)}}
    found, _ = parts.validation_section(judged_scene(), replace(MEASURED, scene=scene, errors=errors), (None, None))
    largest = 1e3 * max(1e-3 * scene.lengths["C"], 2e-3 * scene.lengths["M"])
    assert found.sentences[3] == f"comparison error E of measured and exact places, at most: {largest:.2f} mm"


@pytest.mark.parametrize(
    ("study", "numerical"),
    [
        (model_study(), "0.060 mm"),  # its own run is off by 3e-4 L
        (model_study(runs={}), "< 1e-9 mm"),
        (model_study(runs={"as it is": made.judged_run("as it is", errors=None)}), "< 1e-9 mm"),
        (loop_study(), "< 1e-9 mm"),
        (scene_study(), "< 1e-9 mm"),
    ],
    ids=["a model", "a model without runs", "a failed run", "loops", "no runs"],
)
def test_the_numerical_error_is_that_of_judged_runs(study: Any, numerical: str) -> None:
    found, _ = parts.validation_section(study, MEASURED, (None, None))
    assert found.sentences[4] == f"u_num, the numerical error of the judged runs: {numerical}"


# -- domain of validity and invariances --------------------------------------------------------------------------------


def limit_study(**parameters: float) -> LimitStudy:
    def probe(value: float, level: str, outcome: str, undetected: bool) -> Probe:
        return Probe(value, f"{value:g} steps", level, outcome, undetected, "", None, None)

    probes = (probe(200.0, "safe", "completed", False), probe(50.0, "rough", "completed", False),
              probe(20.0, "broken", "opened", True))  # fmt: skip
    boundaries = (
        Boundary("safe", 200.0, 50.0, "completed", False, ()), Boundary("rough", 50.0, 20.0, "opened", True, ()),
    )  # fmt: skip
    walk = Walk("step", "saw", "mujoco", "tuned", "", probes, boundaries)
    return LimitStudy(
        "saw",
        "saw",
        "a saw",
        dict(SCENE.parameters) | parameters,
        {"mujoco": "9.1", "pymunk": "7.0"},
        (walk,),
        (),
        (),
        (),
    )


def test_the_domain_of_validity_is_that_of_the_limits() -> None:
    head = ("axis", "engine", "preset", "from .. to", "within 1 %", "within 10 %", "beyond 10 %")
    row = ("step", "MuJoCo", "tuned", "200 .. 20 steps", "200 steps", "50 steps", "opened (undetected)")
    section = VerificationSection((Table(head, (row,), names=3),), ("found with mujoco 9.1, pymunk 7.0",))
    assert parts.validity_section(limit_study(), SCENE) == (section, [])
    assert parts.validity_section(limit_study(rod=0.31), SCENE) == (
        section, ["the domain of validity was found with other parameters"],
    )  # fmt: skip


def test_domain_of_validity_is_missing_unless_given() -> None:
    words = "missing: no results of `conrod limits` were given (`--limits DIR`)"
    for study, scene in ((None, SCENE), (limit_study(), None)):
        assert parts.validity_section(study, scene) == (VerificationSection((), (words,)), [])


def test_broken_invariances_are_open_deviations() -> None:
    holds = Invariance("order of bodies", "bits", InvarianceOutcome.BITS)
    broken = Invariance("unit of length", "rounding", InvarianceOutcome.BROKEN, 1e-3, 2e4, 0.5)
    head = ("changed", "must hold to", "difference", "over its bound", "verdict")
    for found, words, deviations in (
        ((holds,), "None of 1 invariances is broken.", []),
        (
            (holds, broken),
            "1 of 2 invariances is BROKEN: unit of length (0.0010 of the largest acceleration, first at 0.5 s).",
            ["1 of 2 invariances is BROKEN: unit of length (0.0010 of the largest acceleration, first at 0.5 s)."],
        ),
    ):
        section, off = parts.invariances_section(InvarianceStudy("saw", "9.1", "ten steps", found))
        (table,) = section.tables
        assert table.headings == head
        assert [row[0] for row in table.rows] == [one.change for one in found]
        assert section.sentences == (words,)
        assert off == deviations
    assert parts.invariances_section("they are those of a model") == (
        VerificationSection((), ("missing: they are those of a model",)), [],
    )  # fmt: skip
