"""The page of a verification report: each section under its heading, its data, and changes since an earlier one."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import replace

import pytest

from conrod.errors import InvalidInput
from conrod.report.table import ColouredCell, Table, table
from conrod.verification.page import (
    ChangeRecord,
    Verification,
    VerificationSection,
    read_verification,
    sealed_page,
    statement_changes,
    valid_seal,
)

HEADINGS = {
    "criteria": "2. Criteria, fixed before the run",
    "code": "3. Code verification",
    "solution": "4. Solution verification",
    "validation": "5. Validation",
    "inputs": "6. Input pedigree",
    "software": "7. Software and platform",
    "settings": "8. Settings and command",
    "validity": "9. Domain of validity",
    "invariances": "10. Invariances",
    "parameters": "11. Uncertainty of parameters",
}


def report(*changes: ChangeRecord, deviations: tuple[str, ...] = (), **sections: VerificationSection) -> Verification:
    """A report that has a sentence of its own in each section."""
    own = {name: VerificationSection((), (f"what is found of {name}",)) for name in HEADINGS}
    made, command = "2026-01-02 03:04 UTC", "conrod validate saw --verification r.html"
    return Verification("saw", "within tolerance", made, command, own | sections, deviations, changes)


def parts(page: str) -> dict[str, str]:
    """Text of each part of a page by its heading, without tags and with single blanks."""
    main = page[page.index("<main>") : page.index("</main>")]
    _, *found = re.split(r"<h[12][^>]*>(.*?)</h[12]>", main, flags=re.DOTALL)
    texts = (" ".join(re.sub(r"<[^>]*>", " ", text).split()) for text in found[1::2])
    return dict(zip(found[::2], texts, strict=True))


def test_page_has_each_section_under_its_heading() -> None:
    page = sealed_page(report()).decode()
    found = parts(page)
    for name, heading in HEADINGS.items():
        assert f"what is found of {name}" in found[heading], heading
        assert found[heading].count("what is found of") == 1
    assert list(found) == [
        "Verification report: saw", "1. Intended use and its limits", *HEADINGS.values(),
        "12. Record of changes", "13. Open deviations", "14. Author, reviewer, date",
    ]  # fmt: skip
    first = found["Verification report: saw"]
    assert "within tolerance" in first
    assert "Validation not performed" in first
    assert "Open deviations: none (section 13)." in first
    seal = valid_seal(page.encode())
    assert f"Made 2026-01-02 03:04 UTC. SHA-256 of this file, with zeros in place of the hash: {seal}" in first
    assert found["8. Settings and command"].endswith("conrod validate saw --verification r.html")
    assert found["12. Record of changes"] == "No earlier report stood in its place."
    assert found["13. Open deviations"] == "None."


def test_page_shows_tables_changes_and_deviations() -> None:
    rows = table(("run", "found"), [("own", ColouredCell("1e-5", "bad")), ("other", "2e-5")])
    earlier = ChangeRecord("a" * 64, "2026-01-01 00:00 UTC", ("one change", "another change"))
    measured = VerificationSection((), ("t.csv: 7 rows", "E is within"))
    found = parts(
        sealed_page(
            report(
                earlier, deviations=("a first", "a second"), solution=VerificationSection((rows,)), validation=measured
            )
        ).decode()
    )
    assert found["4. Solution verification"].endswith("run found own 1e-5 other 2e-5")
    assert found["12. Record of changes"] == (
        f"2026-01-01 00:00 UTC, since the report of SHA-256 {'a' * 64} : one change another change"
    )
    assert found["13. Open deviations"] == "a first a second"
    first = found["Verification report: saw"]
    assert "Section 5 compares with measurements. Open deviations: 2 (section 13)." in first
    assert found["5. Validation"] == "t.csv: 7 rows E is within"


def test_page_is_one_html_document_with_its_data_at_the_end() -> None:
    one = report(deviations=("a <b> & \x1b é",))
    page = sealed_page(one).decode()
    assert page.startswith("<!doctype html>")
    assert page.count('<section aria-labelledby="verification">') == 1
    assert page.count("<title>Verification report: saw</title>") == 1
    assert page.count('<h1 id="verification">Verification report: saw</h1>') == 1
    assert page.count('<meta name="conrod-verification" content="2">\n</head>') == 1
    # Tags, and what commands a terminal, are escaped in the data; other letters stand as they are.
    (data,) = re.findall(
        r'<script type="application/json" id="conrod-verification-data">(.*)</script>\n</body>\n</html>\n?$',
        page,
        re.DOTALL,
    )
    assert r'"deviations": ["a \u003cb> & \u001b é"], "record": [], "title": ""}' in data
    assert json.loads(data)["deviations"] == ["a <b> & \x1b é"]
    assert read_verification(page.encode()) == one
    assert "\x1b" not in page


@pytest.mark.parametrize("letter", ["\x7f", "\x9b", "\u202e", "\u2028"])
def test_letter_that_commands_is_read_as_it_was_written(letter: str) -> None:
    one = report(deviations=(f"a{letter}b",))
    page = sealed_page(one)
    assert letter not in page.decode()
    assert read_verification(page) == one


def test_links_to_other_pages_are_text_alone() -> None:
    page = sealed_page(report(deviations=("see [the page](page.md)",))).decode()
    assert parts(page)["13. Open deviations"] == "see the page"
    assert "page.md" not in page[: page.index("</main>")]


def test_seal_is_the_hash_of_the_page_with_zeros_in_its_place() -> None:
    page = sealed_page(report())
    seal = valid_seal(page)
    assert seal is not None
    assert hashlib.sha256(page.replace(seal.encode(), b"0" * 64)).hexdigest() == seal
    with pytest.raises(InvalidInput, match=r"^it is no verification report of conrod$"):
        valid_seal(b"<p>another page</p>")
    with pytest.raises(InvalidInput, match=r"^it has no data of a verification report$"):
        read_verification(page.replace(b"conrod-verification-data", b"conrod-verification-date"))


# -- changes between reports ------------------------------------------------------------------------------------------


def criteria(*rows: tuple[str, str, str, str]) -> VerificationSection:
    return VerificationSection((Table(("run", "quantity", "criterion", "found"), rows, names=2),))


def test_changes_of_subject_verdict_and_command_are_named() -> None:
    before = report()
    after = replace(before, subject="press", verdict="OUT", command="conrod validate press", made="2027", record=())
    assert statement_changes(before, after) == (
        "report, on: saw -> press",
        "report, verdict: within tolerance -> OUT",
        "report, command: conrod validate saw --verification r.html -> conrod validate press",
    )


def test_changes_of_deviations_are_named_one_by_one() -> None:
    before, after = report(deviations=("one", "two")), report(deviations=("two", "three"))
    assert statement_changes(before, after) == ("deviations, one: open -> absent", "deviations, three: absent -> open")
    assert statement_changes(report(), report(deviations=("two",))) == ("deviations, two: absent -> open",)


@pytest.mark.parametrize(
    ("before", "after", "change"),
    [
        (("0.001", "1e-4"), ("0.002", "1e-4"), "0.001; 1e-4 -> 0.002; 1e-4 (LOOSENED)"),
        (("0.002", "1e-4"), ("0.001", "1e-4"), "0.002; 1e-4 -> 0.001; 1e-4"),
        (("0.001 m", "1e-4 m"), ("0.001 m", "2e-4 m"), "0.001 m; 1e-4 m -> 0.001 m; 2e-4 m"),
        (("0.25 deg", "0.1 deg"), ("0.5 deg", "0.1 deg"), "0.25 deg; 0.1 deg -> 0.5 deg; 0.1 deg (LOOSENED)"),
        (("0.001", "1e-4"), None, "0.001; 1e-4 -> absent (LOOSENED)"),
        (None, ("0.001", "1e-4"), "absent -> 0.001; 1e-4"),
    ],
)
def test_a_criterion_that_allows_more_is_marked(
    before: tuple[str, str] | None, after: tuple[str, str] | None, change: str
) -> None:
    old, new = (
        report(criteria=criteria(("own", "velocity", "1", "0"), *([("own", "position", *cells)] if cells else [])))
        for cells in (before, after)
    )
    assert statement_changes(old, new) == (f"criteria, own position: {change}",)


def test_rows_of_other_sections_are_never_loosened() -> None:
    old, new = (report(solution=criteria(("own", "position", size, "0"))) for size in ("1", "2"))
    assert statement_changes(old, new) == ("solution, own position: 1; 0 -> 2; 0",)


def test_a_section_that_comes_or_goes_is_counted_in_rows() -> None:
    rows = criteria(("own", "position", "1", "0"), ("own", "velocity", "1", "0"))
    assert statement_changes(report(), report(code=rows)) == ("code: 0 rows -> 2 rows",)
    assert statement_changes(report(code=rows), report()) == ("code: 2 rows -> 0 rows",)
    # Of criteria each row counts.
    assert statement_changes(report(), report(criteria=rows)) == (
        "criteria, own position: absent -> 1; 0",
        "criteria, own velocity: absent -> 1; 0",
    )


def test_settings_are_told_apart_by_their_engines() -> None:
    def settings(other: str) -> Verification:
        engines = [
            Table(("setting", "tuned"), (("`step`", value),), title=title)
            for title, value in (("MuJoCo", "0.001"), ("Pymunk", other))
        ]
        return report(settings=VerificationSection(tuple(engines)))

    assert statement_changes(settings("0.002"), settings("0.004")) == ("settings, Pymunk `step`: 0.002 -> 0.004",)
    # Titles of other sections' tables are no names.
    titled = [report(code=VerificationSection((Table(("run", "order"), (("own", n),), title="T"),))) for n in "12"]
    assert statement_changes(*titled) == ("code, own: 1 -> 2",)


def test_validation_is_compared_by_its_words() -> None:
    old, new = (report(validation=VerificationSection((), ("t.csv", f"E is {size}"))) for size in ("0.1 mm", "0.2 mm"))
    assert statement_changes(old, new) == ("validation, words: t.csv; E is 0.1 mm -> t.csv; E is 0.2 mm",)
