"""`conrod doctor`."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from conrod.cli import FAILED, options, waiting

if TYPE_CHECKING:
    from conrod.guide.doctor.api import Diagnosis
    from conrod.report.terminal import PrintedPart


@options.verb()
@options.document
def doctor(document: str | None) -> None:
    """Check this installation: versions, engines, and whether wrong runs are noticed here.

    One machine is run in both engines, and three defects are planted into each run, which the verdict has to notice.

    Exit status 0: all is well; 1: a version is out of range, a run is out of tolerance, or a defect passes.
    """
    from conrod.comparison.plain_values import json_document, plain_values
    from conrod.execution.files import files_to_write
    from conrod.execution.writing import single_file, write_together
    from conrod.guide.doctor import api
    from conrod.report.terminal import print_parts

    files = files_to_write({"--json": document})
    with waiting("self-test", None):
        found = api.doctor()
    print_parts(diagnosis_to_print(found))
    if "--json" in files:
        write_together([single_file(files["--json"], json_document(plain_values(found) | {"passed": found.passed}))])
    if not found.passed:
        sys.exit(FAILED)


def diagnosis_to_print(found: Diagnosis) -> Iterator[PrintedPart]:
    """Yield versions, engines and self-tests as lines and tables, and the verdict last."""
    from conrod.guide.doctor.api import TESTED_SCENE
    from conrod.report.terminal import verdict_line

    yield found.system
    yield from found.tables()
    for test in found.tests:
        noticed = f"of planted defects noticed: {', '.join(test.noticed) or 'none'}"
        missed = f"; NOT NOTICED: {', '.join(test.missed)}" if test.missed else ""
        yield verdict_line(f"{TESTED_SCENE} in {test.engine}: {test.verdict}; {noticed}{missed}", test.passed)
    yield verdict_line(found.verdict if found.passed else f"{found.verdict}: see above", found.passed)
    outside = [f"'{one.name}{one.allowed}'" for one in found.packages if not one.good]
    if outside:
        yield f"mend it: pip install {' '.join(outside)}"
