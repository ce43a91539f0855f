"""mutmut, with the files of tests nearest to a planted defect collected and run before others (`make mutants`).

How tests look for a defect is a method of mutmut's class that runs pytest: that class alone is another here.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from mutmut.__main__ import cli, create_mutants
from mutmut.mutation.trampoline import set_mutant_under_test
from mutmut.runners.harness import PytestRunner
from mutmut.state import state
from mutmut.utils.file_utils import change_cwd, copy_also_copy_files, copy_src_dir
from mutmut.workers import isolation
from nearest_tests import Search, exit_code_of, file_of, text_of

PASSED_BEFORE = "MUTANT_TESTS_PASSED"  # of `sampled_mutants`: all tests were run without a defect just now
FILES = 3  # of tests, that a process runs at once to see what they reach


class NearestRunner(PytestRunner):
    """Runs the tests that reach a defect, a few files at a time, until one fails."""

    def warm_up(self) -> None:
        """Import what tests need, and read their files, in the process that those for each defect are forked from."""
        super().warm_up()
        with change_cwd("mutants"):
            for test in state().duration_by_test:
                text_of(file_of(test))

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

    def run_stats(self, *, tests: Iterable[str]) -> int:
        """See which functions each test reaches and how long it takes, on all processors; 0 where all pass."""
        by_file: dict[str, list[str]] = defaultdict(list)
        for test in sorted(tests or self.list_all_tests().ids):
            by_file[file_of(test)].append(test)
        files = [by_file[file] for file in sorted(by_file)]
        parts = [[test for file in files[k : k + FILES] for test in file] for k in range(0, len(files), FILES)]
        with ProcessPoolExecutor(os.cpu_count()) as pool:
            ends = [_take(found) for found in pool.map(_stats_of, parts)]
        return max(ends)


def _stats_of(tests: list[str]) -> tuple[int, Any]:
    """What tests reach and how long they take; pytest's exit code before it."""
    for known in (state().tests_by_mangled_function_name, state().duration_by_test, state().function_dependencies):
        known.clear()
    code = PytestRunner().run_stats(tests=tests)
    return code, (
        dict(state().tests_by_mangled_function_name),
        dict(state().duration_by_test),
        dict(state().function_dependencies),
    )


def _take(found: tuple[int, Any]) -> int:
    """Add what a process saw to mutmut's state; the exit code of its tests."""
    code, (reached, durations, callers) = found
    state().duration_by_test.update(durations)
    for name, tests in reached.items():
        state().tests_by_mangled_function_name[name] |= tests
    for name, functions in callers.items():
        state().function_dependencies[name] |= functions
    return code


@cli.command()
def generate() -> None:
    """Write the modules with all their defects, of which each is left out until its name is asked for."""
    set_mutant_under_test("mutant_generation")
    Path("mutants").mkdir(exist_ok=True)
    copy_src_dir()
    copy_also_copy_files()
    create_mutants(os.cpu_count() or 2)


if __name__ == "__main__":
    isolation.PytestRunner = NearestRunner  # type: ignore[misc]
    cli()
