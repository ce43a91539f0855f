"""Verification reports: a changed byte is seen, a loosened criterion named, and what is not so an open deviation."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import conrod, refusal
from encoder_table import encoder_table
from own_model_edits import ROD_END, TEXTS, replace_once

from conrod.comparison.convergence import numerical_uncertainty
from conrod.models.check.references import SENSITIVITY_ANGLES, sensitivities, uncertainty_shares
from conrod.models.tables.columns import column_request
from conrod.models.tables.reading import read_table
from conrod.models.tables.study import TableStudy, study_table
from conrod.report.table import table
from conrod.scenes import SCENES
from conrod.verification import page as pages
from conrod.verification import supporting_sections
from conrod.verification.page import (
    Verification,
    VerificationSection,
    read_verification,
    sealed_page,
    statement_changes,
    valid_seal,
)
from conrod.verification.sections import Refinement
from conrod.verification.verb import Dossier

REPORTS = Path(__file__).parents[2] / "reports" / "verification"
NAMES = ("criteria", "code", "solution", "validation", "inputs", "software", "settings", "validity", "invariances")
HOSTILE = "</script><script>a()</script><img src=x onerror=a()>"


def report(allowed: float = 1e-4, subject: str = "saw") -> Verification:
    """A report with one criterion."""
    criteria = table(
        ("run", "quantity", "criterion", "found"), [("own", "position", f"{allowed:.6g}", "1e-5")], names=2
    )
    sections = {name: VerificationSection((), ("nothing",)) for name in (*NAMES, "parameters")}
    sections["criteria"] = VerificationSection((criteria,))
    return Verification(subject, "within tolerance", "2026-01-01 00:00 UTC", f"conrod {subject}", sections, ())


def reseal(page: bytes) -> bytes:
    """A changed page with a hash that fits, as anybody can make it."""
    found = pages.SEAL.search(page)
    bare = page.replace(found[1], pages.UNSEALED)
    return bare.replace(pages.UNSEALED, hashlib.sha256(bare).hexdigest().encode())


def refinement_of(*errors: float | None, formal: int | None = 4) -> Refinement:
    return Refinement("run", "position", 200, tuple((100 * 2**k, error) for k, error in enumerate(errors)), formal)


def test_one_changed_byte_anywhere_breaks_the_seal() -> None:
    page = sealed_page(report())
    assert valid_seal(page)
    head = page.index(b"SHA-256 of this file")
    for at in {*range(0, len(page), 29), *range(head - 20, head + 110), len(page) - 1}:
        changed = page[:at] + bytes([page[at] ^ 1]) + page[at + 1 :]
        assert not valid_seal(changed), page[at - 10 : at + 10]
    assert not valid_seal(page + b"\n")
    assert not valid_seal(page.replace(b"\n", b"\r\n"))


def test_the_hash_is_zeroed_at_one_place_alone() -> None:
    page = sealed_page(report())
    seal = str(valid_seal(page)).encode()
    assert page.count(seal) == 1
    assert hashlib.sha256(page.replace(seal, pages.UNSEALED)).hexdigest().encode() == seal
    for changed in (
        page.replace(seal, pages.UNSEALED),
        page.replace(b"</main>", b"<p>" + seal + b"</p></main>"),
        page.replace(b"</main>", b"<p>" + pages.UNSEALED + b"</p></main>"),
        page.replace(b"</main>", b"SHA-256 of this file: <code>" + seal + b"</code></main>"),
        page.replace(b"</main>", b"SHA-256 of this file: <code>" + pages.UNSEALED + b"</code></main>"),
        page.replace(b"SHA-256 of this file", b"SHA-256 of that file"),
        page.replace(seal, seal.upper()),
        page.replace(b'content="2"', b'content="sha256:' + seal + b'"'),
    ):
        assert changed != page
        assert valid_seal(changed) is None
    # A subject that looks like the field is text, and no second one.
    assert valid_seal(sealed_page(report(subject="SHA-256 of this file: <code>" + "0" * 64 + "</code>")))


def test_page_of_an_earlier_version_is_verified_in_both_places() -> None:
    mark = f'<meta name="conrod-verification" content="sha256:{"0" * 64}"><code>{"0" * 64}</code>'.encode()
    seal = hashlib.sha256(mark).hexdigest().encode()
    page = mark.replace(pages.UNSEALED, seal)
    assert valid_seal(page) == seal.decode()
    head, _, tail = page.rpartition(seal)
    assert valid_seal(head + pages.UNSEALED + tail) is None
    assert valid_seal(page + seal) is None


def test_the_first_line_says_what_the_hash_does_not_do() -> None:
    html = sealed_page(report()).decode()
    first = html[html.index("<h1") :].split("<p>")[1]
    assert first.startswith("Not signed: the hash below says whether a byte of this file was changed")


@pytest.mark.skipif(shutil.which("ssh-keygen") is None, reason="no ssh-keygen here")
def test_a_page_is_signed_as_the_documents_say(tmp_path: Path) -> None:
    file, key = tmp_path / "report.html", tmp_path / "key"
    file.write_bytes(sealed_page(report()))
    subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", key], check=True)
    (tmp_path / "allowed_signers").write_text("me@example.org " + key.with_suffix(".pub").read_text())
    text = (Path(__file__).parents[2] / "docs/verification.md").read_text(encoding="utf-8")
    sign, verify = (line.split("#")[0].split() for line in text.splitlines() if line.startswith("ssh-keygen"))
    subprocess.run([str(key) if word.startswith("~") else word for word in sign], cwd=tmp_path, check=True)

    def check() -> int:
        with file.open("rb") as page:
            return subprocess.run(verify[: verify.index("<")], cwd=tmp_path, stdin=page, check=False).returncode

    assert check() == 0
    file.write_bytes(file.read_bytes() + b" ")
    assert check() != 0


def test_hostile_subject_stays_text() -> None:
    page = sealed_page(report(subject=HOSTILE)).decode()
    assert "<img" not in page
    assert page.count("<script") == 2  # conrod's own, and the data
    assert read_verification(page.encode()).subject == HOSTILE


@pytest.mark.parametrize(
    ("change", "status", "said"),
    [
        (lambda page: page, 0, "unchanged, SHA-256"),
        (lambda page: page.replace(b"1e-5", b"1e-6", 1), 1, "CHANGED"),
        (lambda page: b"<p>another page</p>", 2, "no verification report of conrod"),
    ],
)
def test_verify_reports_by_its_exit_status(change: Any, status: int, said: str, tmp_path: Path) -> None:
    file = tmp_path / "r.html"
    file.write_bytes(change(sealed_page(report())))
    done = conrod("report", "--verify", str(file))
    assert done.returncode == status
    assert said in done.stdout + done.stderr


def test_loosened_criterion_is_named_and_a_tighter_one_is_not() -> None:
    (one,) = statement_changes(report(1e-4), report(1e-3))
    assert one == "criteria, own position: 0.0001; 1e-5 -> 0.001; 1e-5 (LOOSENED)"
    assert "LOOSENED" not in statement_changes(report(1e-3), report(1e-4))[0]
    none = replace(report(), sections={**report().sections, "criteria": VerificationSection()})
    assert statement_changes(report(), none)[0].endswith("absent (LOOSENED)")
    assert statement_changes(report(), report()) == ()


def test_an_order_that_is_off_or_not_shown_is_a_deviation() -> None:
    assert not refinement_of(16e-6, 1e-6, 1e-6 / 16, 1e-6 / 256).is_off
    assert refinement_of(8e-6, 4e-6, 2e-6, 1e-6).is_off
    assert refinement_of(16e-6, 1e-6, 1e-6, 1e-6).is_off
    # A plateau that the three finest approach at the formal order is an error all the same.
    assert refinement_of(*(1e-6 + 1e-6 / 16**k for k in range(4))).is_off
    assert not refinement_of(1e-12, 2e-12, 1e-12, 3e-12).is_off
    assert not refinement_of(8e-6, 4e-6, 2e-6, 1e-6, formal=None).is_off
    assert refinement_of(None, None, None).is_off
    assert refinement_of(16e-6, 1e-6, None).is_off
    # Where the coarsest run is too coarse the three finest show it.
    assert not refinement_of(1e-3, 1e-6, 1e-6 / 16, 1e-6 / 256).is_off


def test_an_order_may_be_off_by_a_quarter(monkeypatch: pytest.MonkeyPatch) -> None:
    for order, off in ((3.75, False), (4.25, False), (4.26, True), (3.74, True)):
        monkeypatch.setattr(Refinement, "order", order)
        assert refinement_of(1e-6, 1e-6).is_off is off


def test_uncertainty_is_safety_factor_times_distance_to_limit() -> None:
    path = [(20, 7.0), *((n, 0.3 + 5.0 * n**-2.0) for n in (50, 150, 450))]  # the three finest count
    for steps, finer in ((150, 150), (1000, 450)):
        assert numerical_uncertainty(path, steps) == pytest.approx((2.0, 0.3, 1.25 * 5.0 / finer**2))
    # An order counts up to the formal one: to 2 where none is stated.
    steep = [(n, 0.3 + (100 / n) ** 4) for n in (50, 100, 200)]
    for formal, limit in ((4, 0.3), (None, 0.3 + 1 / 16 - 15 / 16 / 3)):
        assert numerical_uncertainty(steep, 200, formal) == pytest.approx((4.0, limit, 1.25 * (0.3 + 1 / 16 - limit)))
    assert numerical_uncertainty([(25, 17.0), (100, 13.0), (400, 11.0)], 400) == (0.5, 9.0, 2.5)  # a half is shown
    assert numerical_uncertainty([(50, 1.0), (100, 1.0), (200, 1.5)], 200) == (None, 2.0, 1.5)
    assert numerical_uncertainty([(50, 1.0), (100, 2.0), (200, 1.5)], 200) == (None, 1.0, 1.5)
    assert numerical_uncertainty([(50, 1.0), (100, None), (200, 1.5)], 200) is None


def test_sensitivities_are_derivatives_of_the_closed_form() -> None:
    press = SCENES["shear-press"]
    crank, rod = press.parameters["crank"], press.parameters["rod"]
    angle = press.kinematics.angles(SENSITIVITY_ANGLES)
    across = np.sqrt(rod**2 - (crank * np.sin(angle)) ** 2)  # the slider's distance from the pin, along its line
    found = sensitivities(press)
    assert np.abs(found["rod"] - rod / across).max(axis=1).min() < 1e-8
    together, parts = uncertainty_shares(found, {"rod": 1e-4})
    assert together == pytest.approx(1e-4 * found["rod"].max())
    assert parts == {"crank": 0.0, "rod": 1.0}


def test_wrong_rod_is_a_deviation_with_its_effect_on_a_point(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Other runs take most of the time, and nothing is asked of them.
    monkeypatch.setattr("conrod.models.check.study.LABELS", ("as it is",))
    monkeypatch.setattr("conrod.models.check.study.STEP_REFINEMENTS", ())
    monkeypatch.setattr(Dossier, "_invariances", lambda *_: "left out")
    (tmp_path / "saw.xml").write_text(replace_once(TEXTS["saw"], ROD_END, 'name="slider-pin.rod" pos="0.3003 0 0"'))
    given = ("--scene", "saw-40rpm", "--crank", "crank", "--point", "C=site:C", "--revolutions", "1")
    done = conrod("check", str(tmp_path / "saw.xml"), *given, "--verification", str(tmp_path / "r.html"))
    assert done.returncode == 1
    page = (tmp_path / "r.html").read_bytes()
    found = read_verification(page)
    assert (
        "rod of the model is off by 0.30 mm: by its sensitivity that moves a point by up to 0.39 mm" in found.deviations
    )
    assert any("rod is 0.1 % too long" in sentence for sentence in found.deviations)
    assert any("no criterion was fixed" in sentence for sentence in found.deviations)
    # Nothing of where the file is.
    assert str(tmp_path).encode() not in page


def study_measurements(folder: Path, text: str) -> TableStudy:
    path = folder / "encoder.csv"
    path.write_text(text)
    scene = SCENES["saw-40rpm"]
    return study_table(
        "encoder.csv", "saw-40rpm", scene, read_table(path, tuple(scene.lengths), column_request({}, (), ()))
    )


def test_measurements_are_held_to_a_complete_uncertainty_alone(
    tmp_path: Path,
) -> None:
    table_study = study_measurements(tmp_path, encoder_table())
    within, none = supporting_sections.validation_section(None, table_study, (9e-5, 1e-5))
    assert none == []
    assert "does not stand out" in within.sentences[-1]
    beyond, off = supporting_sections.validation_section(None, table_study, (1e-5, 1e-5))
    assert off
    assert "an error of the model stands out" in beyond.sentences[-1]
    unknown, _ = supporting_sections.validation_section(None, table_study, (9e-5, None))
    assert "no validation uncertainty" in unknown.sentences[-1]


def test_verification_refuses_loss_or_mistake_in_one_line(tmp_path: Path) -> None:
    file, other, older = (tmp_path / f"{name}.html" for name in ("r", "other", "older"))
    file.write_bytes(sealed_page(report()).replace(b"1e-5", b"1e-6", 1))
    other.write_text("<p>mine</p>")
    older.write_bytes(reseal(sealed_page(report()).replace(b'"subject"', b'"about"')))
    assert valid_seal(older.read_bytes())
    for arguments, said in {
        ("saw-500rpm", "--verification", str(file)): "it was changed after it was written",
        ("saw-500rpm", "--verification", str(other)): "no verification report of conrod; give another name",
        ("saw-500rpm", "--verification", str(older)): "do not fit Verification",
        ("saw-500rpm", "saw-40rpm", "--verification", str(tmp_path / "new.html")): "one machine or file",
        ("saw-500rpm", "--limits", "reports"): "--limits does not go with no --verification",
        ("saw-500rpm", "--verification", str(tmp_path), "--preset", "tuned"): "it is a folder",
        ("saw-500rpm", "--verification", "new.html", "--uncertainty", "rood=1mm"): "did you mean 'rod'",
        (
            "saw-500rpm",
            "--verification",
            "new.html",
            "--limits",
            str(tmp_path),
        ): "no limits of saw-500rpm, but of nothing",
        ("saw-500rpm", "--verification", "new.html", "--measured", "nothing.csv"): "there is no such file",
        ("--motion", "free", "saw-500rpm", "--verification", "new.html"): "is now `conrod free saw-500rpm",
    }.items():
        done = conrod("validate", *arguments)
        assert (done.returncode, done.stdout) == (2, ""), arguments
        assert said in done.stderr
        assert len(done.stderr.splitlines()) == 1
    assert other.read_text() == "<p>mine</p>"
    assert "No such option '--verification'" in refusal("free", "saw-500rpm", "--verification", "new.html")
    assert not (tmp_path / "new.html").exists()


def test_committed_reports_and_their_inputs_are_unchanged() -> None:
    pages = sorted(REPORTS.glob("*.html"))
    assert len(pages) == 2
    for page in pages:
        assert valid_seal(page.read_bytes())
    assert (REPORTS / "inputs" / "encoder.csv").read_text() == encoder_table()
    model, scene = (page.read_text() for page in pages)
    assert "Validation not performed" in scene
    assert "Validation not performed" not in model


@pytest.mark.slow
@pytest.mark.parametrize("name", ["saw-500rpm", "hacksaw"])
def test_committed_report_made_again_differs_in_software_alone(name: str, tmp_path: Path) -> None:
    old = read_verification((REPORTS / f"{name}.html").read_bytes())
    places = {"hacksaw.xml": "inputs/hacksaw.xml", "encoder.csv": "inputs/encoder.csv", "limits": "../limits"}
    words = [str(REPORTS / places[word]) if word in places else word for word in old.command.split()[1:-2]]
    assert conrod(*words, "--verification", str(tmp_path / f"{name}.html")).returncode == 0
    again = statement_changes(old, read_verification((tmp_path / f"{name}.html").read_bytes()))
    assert all(change.startswith("software, ") for change in again), again
