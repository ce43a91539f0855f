"""Which tests look for a planted defect first, and when they stop (`make mutants`).

mutmut has pytest collect all tests that reach a function, which takes ten seconds where they are two thousand, and runs
them in no order until one fails. Here the files nearest to the module are collected and run first, further ones only
where those let the defect live, all others for a stated time; and a test that hangs ends soon.
"""

from __future__ import annotations

import functools
import os
import re
import resource
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from statistics import fmean

import pytest

FIRST_FILES = 4  # that are collected at once; then twice as many
FURTHER_SECONDS = 20.0  # [s] of CPU for tests that are not near the module; what outlives them counts as living
HANG_SECONDS, HANG_RATIO = 60.0, 15.0  # a test hangs that takes this time of CPU and this many times its usual one
STOPPED = int(pytest.ExitCode.INTERRUPTED)  # exit status where a defect outlived the time of further tests
NAMED, IMPORTING, FURTHER = range(3)  # how near a file of tests is to a module


def distance(file: str, text: str, module: str) -> int:
    """How near a file of tests is to a module: named after it, in a folder of its name, importing it, or further."""
    package, _, name = module.rpartition(".")
    *folders, stem = Path(file).with_suffix("").parts
    if name in folders or f"_{name}_" in f"_{stem}_":
        return NAMED
    own = rf"\b{re.escape(module)}\b|^from {re.escape(package)} import .*\b{re.escape(name)}\b"
    return IMPORTING if re.search(own, text, re.MULTILINE) else FURTHER


def nearest_first(tests: Sequence[str], distances: Mapping[str, int], durations: Mapping[str, float]) -> list[str]:
    """Order tests, `file::test`: near files before others, then files of quick tests; a file's tests stay together.

    A file stays whole since what its tests share would be made again after each test of another file.
    """
    by_file: dict[str, list[float]] = defaultdict(list)
    for test in tests:
        by_file[file_of(test)].append(durations.get(test, 0.0))

    def place(test: str) -> tuple[int, float, str, float]:
        return distances[file_of(test)], fmean(by_file[file_of(test)]), file_of(test), durations.get(test, 0.0)

    return sorted(tests, key=place)


class Search:
    """Look for one defect, with a few files of tests at a time; a plugin of pytest.

    Attributes:
        over: True once tests that are not near had their time.
    """

    def __init__(self, mutant: str, tests: Sequence[str], durations: Mapping[str, float]) -> None:
        module = mutant.rpartition("__mutmut_")[0].rpartition(".")[0]
        self._durations = durations
        self._distances = {file: distance(file, text_of(file), module) for file in {file_of(test) for test in tests}}
        self._tests = nearest_first(tests, self._distances, durations)
        self._further_since: float | None = None
        self.over = False

    def batches(self) -> Iterator[list[str]]:
        """Files in the order in which they are collected: a few, then twice as many, and so on."""
        files, count = list(dict.fromkeys(file_of(test) for test in self._tests)), FIRST_FILES
        while files:
            yield files[:count]
            files, count = files[count:], 2 * count

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Leave the tests of collected files that reach the defect, in their order."""
        by_name = {item.nodeid: item for item in items}
        items[:] = [by_name[name] for name in self._tests if name in by_name]

    def pytest_runtest_protocol(self, item: pytest.Item) -> None:
        """Limit a test's time of CPU, and stop after those tests that are not near have had theirs."""
        _, most = resource.getrlimit(resource.RLIMIT_CPU)
        limit = time.process_time() + HANG_SECONDS + HANG_RATIO * self._durations.get(item.nodeid, 0.0)
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit if most < 0 else min(limit, most)), most))
        if self._distances[file_of(item.nodeid)] == FURTHER:
            spent = sum(os.times()[:4])  # with processes that tests began
            self._further_since = spent if self._further_since is None else self._further_since
            if spent - self._further_since > FURTHER_SECONDS:
                self.over = True
                item.session.shouldstop = f"lived within {FURTHER_SECONDS:g} s of further tests"


def exit_code_of(search: Search, run: Callable[[list[str]], int]) -> int:
    """Exit code of pytest for the first files whose tests find a defect; 0 or `STOPPED` where it lives.

    Args:
        run: runs the tests of files that are looked for, and returns pytest's exit code.
    """
    for files in search.batches():
        code = run(files)
        if code == STOPPED and search.over:
            return STOPPED
        if code not in {pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED}:
            return int(pytest.ExitCode.TESTS_FAILED) if code == STOPPED else code  # files that cannot be collected
    return int(pytest.ExitCode.OK)


def file_of(test: str) -> str:
    """The file of a test."""
    return test.split("::", maxsplit=1)[0]


@functools.cache
def text_of(file: str) -> str:
    """A file's text, read once."""
    return Path(file).read_text(encoding="utf-8")
