"""Which tests look for a planted defect first, and when they stop (`make mutants`); hooks of pytest, see conftest.py.

mutmut runs all tests that reach a function, in no order, until one fails. Here those nearest to the module run first,
the others for a stated time, and a test that hangs ends soon.
"""

from __future__ import annotations

import functools
import json
import os
import re
import resource
import time
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import fmean

import pytest

UNDER_TEST = "MUTANT_UNDER_TEST"  # of mutmut: the mutant's name; empty without a defect
PASSED_BEFORE = "MUTANT_TESTS_PASSED"  # of `sampled_mutants`: all tests were run without a defect just now
DURATIONS = Path("mutmut-stats.json")  # of mutmut, in the folder that it runs tests in
FURTHER_SECONDS = 20.0  # [s] of CPU for tests that are not near the module; what outlives them counts as living
HANG_SECONDS, HANG_RATIO = 60.0, 15.0  # a test hangs that takes this time of CPU and this many times its usual one
NAMED, IMPORTING, FURTHER = range(3)  # how near a file of tests is to a module
FURTHER_SINCE = pytest.StashKey[float]()


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
        by_file[_file(test)].append(durations.get(test, 0.0))

    def place(test: str) -> tuple[int, float, str, float]:
        return distances[_file(test)], fmean(by_file[_file(test)]), _file(test), durations.get(test, 0.0)

    return sorted(tests, key=place)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Order the tests that look for a defect; leave one of a run without a defect that was made just before."""
    mutant = os.environ.get(UNDER_TEST, "none")
    if not mutant and PASSED_BEFORE in os.environ and not config.option.collectonly:
        del items[1:]
    module = _module(mutant)
    durations = {} if mutant == "stats" else _durations()  # also where tests are only collected: what is read is kept
    if module:
        by_name = {item.nodeid: item for item in items}
        distances = {_file(name): distance(_file(name), _text(_file(name)), module) for name in by_name}
        items[:] = [by_name[name] for name in nearest_first(list(by_name), distances, durations)]


def pytest_runtest_protocol(item: pytest.Item) -> None:
    """Limit a test's time of CPU, and stop after those tests that are not near have had theirs."""
    module = _module(os.environ.get(UNDER_TEST, ""))
    if not module:
        return
    _, most = resource.getrlimit(resource.RLIMIT_CPU)
    limit = time.process_time() + HANG_SECONDS + HANG_RATIO * _durations().get(item.nodeid, 0.0)
    resource.setrlimit(resource.RLIMIT_CPU, (int(limit if most < 0 else min(limit, most)), most))
    if distance(_file(item.nodeid), _text(_file(item.nodeid)), module) == FURTHER:
        spent = sum(os.times()[:4])  # with processes that tests began
        if spent - item.session.stash.setdefault(FURTHER_SINCE, spent) > FURTHER_SECONDS:
            item.session.shouldstop = f"lived within {FURTHER_SECONDS:g} s of further tests"


def _module(mutant: str) -> str:
    """The module that a mutant is of, by mutmut's name for it; nothing where none is planted."""
    return mutant.rpartition("__mutmut_")[0].rpartition(".")[0]


def _file(test: str) -> str:
    return test.split("::", maxsplit=1)[0]


@functools.cache
def _text(file: str) -> str:
    return Path(file).read_text(encoding="utf-8")


@functools.cache
def _durations() -> dict[str, float]:
    """How long each test took without a defect, in s."""
    known = json.loads(DURATIONS.read_text(encoding="utf-8")) if DURATIONS.exists() else {}
    durations: dict[str, float] = known.get("duration_by_test", {})
    return durations
