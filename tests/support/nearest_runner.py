"""mutmut, with the files of tests nearest to a planted defect collected and run before others (`make mutants`).

How tests look for a defect is one method of its class that runs pytest: that class alone is another here.
"""

from __future__ import annotations

import os
from collections.abc import Iterable

from mutmut.__main__ import cli
from mutmut.runners.harness import PytestRunner
from mutmut.state import state
from mutmut.utils.file_utils import change_cwd
from mutmut.workers import isolation
from nearest_tests import Search, exit_code_of, text_of

PASSED_BEFORE = "MUTANT_TESTS_PASSED"  # of `sampled_mutants`: all tests were run without a defect just now


class NearestRunner(PytestRunner):
    """Runs the tests that reach a defect, a few files at a time, until one fails."""

    def warm_up(self) -> None:
        """Import what tests need, and read their files, in the process that those for each defect are forked from."""
        super().warm_up()
        with change_cwd("mutants"):
            for test in state().duration_by_test:
                text_of(test.split("::", maxsplit=1)[0])

    def run_tests(self, *, mutant_name: str | None, tests: Iterable[str]) -> int:
        """Exit code of pytest for the first files whose tests find a defect; without one, for all or a first test."""
        if mutant_name is None:
            some = list(tests)[:1] if PASSED_BEFORE in os.environ else tests
            return super().run_tests(mutant_name=None, tests=some)
        with change_cwd("mutants"):
            search = Search(mutant_name, list(tests), state().duration_by_test)
            return exit_code_of(
                search, lambda files: self.execute_pytest(self._pytest_args_regular_run(files), plugins=[search])
            )


if __name__ == "__main__":
    isolation.PytestRunner = NearestRunner  # type: ignore[misc]
    cli()
