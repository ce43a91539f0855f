"""Plant a sample of mutmut's mutants in each module, those of changed functions first (`make mutants`).

mutmut leaves properties alone, and verdicts are properties: it is run on a copy of the project in which each property
is written as a method beside it, which changes nothing else.
"""

from __future__ import annotations

import argparse
import ast
import fnmatch
import hashlib
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

from killed_mutants import KILLED

ROOT = Path(__file__).parents[2]
COPY = ROOT / "mutants"  # of the project; what mutmut makes lies in a folder of the same name in it
CHOSEN = "chosen.json"
PAGE = "docs/mutants.md"
RUNNER = "tests/support/nearest_runner.py"  # mutmut, with the nearest tests first
DURATIONS = "mutmut-stats.json"  # of mutmut, in the folder that it runs tests in: how long each took
PASSED_BEFORE = "MUTANT_TESTS_PASSED"  # of `nearest_runner`: all tests were run without a defect just now
PROPERTIES = (["property"], ["cached_property"])
CODE, TESTS = ("src/", "pyproject.toml"), ("tests/",)  # what results depend on
SECTION, DEBUG = "[tool.mutmut]", "debug = true"
POLL, SHOWN = 60.0, 30  # [s] from count to count, and lines of its output
GETTER = "_get_"  # of a property's method, as it is called in the copy


def with_getters(source: str) -> str:
    """Write each property of a class as a method and a property of it, line by line: `p = property(_get_p)`."""
    lines = source.splitlines()
    # From the last one up, so that the lines above stay where they are.
    for function in reversed(list(_properties(ast.parse(source)))):
        (decorator,) = function.decorator_list
        indent, end = " " * function.col_offset, function.end_lineno or 0
        lines[end:end] = [f"{indent}{function.name} = {ast.unparse(decorator)}({GETTER}{function.name})"]
        at = function.lineno - 1
        lines[at] = lines[at].replace(f"def {function.name}(", f"def {GETTER}{function.name}(", 1)
        del lines[decorator.lineno - 1]
    return "\n".join(lines) + "\n"


def _properties(module: ast.Module) -> Iterator[ast.FunctionDef]:
    """Functions that are decorated as a property alone, in the order of their lines; a protocol's have no body."""
    classes = (one for one in ast.walk(module) if isinstance(one, ast.ClassDef))
    bodies = (one.body for one in classes if not any(ast.unparse(base).startswith("Protocol") for base in one.bases))
    functions = (one for body in bodies for one in body if isinstance(one, ast.FunctionDef))
    found = (one for one in functions if [ast.unparse(d).split(".")[-1] for d in one.decorator_list] in PROPERTIES)
    yield from sorted(found, key=lambda one: one.lineno)


def copy_project(root: Path, copy: Path) -> bool:
    """Copy a project's files, with methods for properties; True where earlier results in the copy still hold.

    All hold while nothing but tests was edited: a defect that a test finds is found by it among more tests too. After
    an edit of code mutmut keeps the results of functions that are the same, which it knows by their hashes. What
    survived is planted again in both cases (`_results_by_file`).
    """
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=root, capture_output=True, text=True, check=True,
    )  # fmt: skip
    files = sorted(name for name in listed.stdout.split("\0") if name and (root / name).is_file())
    state = {part: _hash_of(root, [name for name in files if name.startswith(part)]) for part in CODE + TESTS}
    mark = copy / ".state"
    before = json.loads(mark.read_text(encoding="utf-8")) if mark.exists() else {}
    if before == state:
        return True
    kept = bool(before) and all(before[part] == state[part] for part in CODE)
    results = {} if not before else _results_by_file(copy)
    if kept:
        shutil.rmtree(copy / "tests")
        files = [name for name in files if name.startswith(TESTS)]
    else:
        shutil.rmtree(copy, ignore_errors=True)
    for file, text in results.items():
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    mutated = _mutated_files(root)
    for name in files:
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        if name in mutated:
            (copy / name).write_text(with_getters((root / name).read_text(encoding="utf-8")), encoding="utf-8")
        else:
            shutil.copy2(root / name, copy / name)
    mark.write_text(json.dumps(state), encoding="utf-8")
    return bool(results)


def _hash_of(root: Path, files: list[str]) -> str:
    """Hash over names and contents of files."""
    state = hashlib.sha256()
    for name in files:
        state.update(name.encode() + b"\0" + (root / name).read_bytes())
    return state.hexdigest()


def _results_by_file(copy: Path) -> dict[Path, str]:
    """Read the files of results that mutmut leaves, with mutants that no test found as not run."""
    results: dict[Path, str] = {}
    for file in (copy / "mutants" / "src").rglob("*.py.meta"):
        found = json.loads(file.read_text(encoding="utf-8"))
        codes = found["exit_code_by_key"]
        found["exit_code_by_key"] = {name: code if code in KILLED else None for name, code in codes.items()}
        results[file] = json.dumps(found, indent=4)
    return results


def _mutated_files(root: Path) -> list[str]:
    """Files that mutants are planted in, by the patterns of pyproject.toml."""
    asked = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["mutmut"]
    left_out = asked.get("do_not_mutate", [])
    files = sorted(str(file.relative_to(root)) for file in (root / "src").rglob("*.py"))
    return [name for name in files if _matches(name, asked["only_mutate"]) and not _matches(name, left_out)]


def _matches(name: str, patterns: Iterable[str]) -> bool:
    return any(fnmatch.fnmatch(name, pattern) for pattern in patterns)


def generate(copy: Path) -> None:
    """Have mutmut write all mutants of a copy of the project."""
    subprocess.run(
        [sys.executable, RUNNER, "generate"], cwd=copy, env=_environment(), stdout=subprocess.DEVNULL, check=True
    )


def _environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": ""}


def mutants_of(copy: Path, name: str) -> tuple[list[str], dict[str, str]]:
    """Names of all mutants of a file, and of each mutated function what tells whether it is still the same."""
    made = json.loads((copy / "mutants" / f"{name}.meta").read_text(encoding="utf-8"))
    return list(made["exit_code_by_key"]), made["hash_by_function_name"]


def changed_functions(root: Path, name: str, since: str, today: dict[str, str]) -> set[str]:
    """Functions of a file, by mutmut's names, that were not the same at an earlier commit."""
    from mutmut.mutation.file_mutation import compute_function_hashes

    before = subprocess.run(["git", "show", f"{since}:{name}"], cwd=root, capture_output=True, text=True, check=False)
    if before.stdout == (root / name).read_text(encoding="utf-8"):
        return set()
    earlier = compute_function_hashes(with_getters(before.stdout)) if before.returncode == 0 else {}
    return {function for function, now in today.items() if earlier.get(function) != now}


def sample(names: list[str], changed: set[str], count: int, seed: str) -> list[str]:
    """At most so many mutants, those of changed functions before others; the same ones each time."""
    order = list(names)
    random.Random(seed).shuffle(order)
    return sorted(order, key=lambda name: _function(name) not in changed)[: count or None]


def _function(mutant: str) -> str:
    return mutant.rpartition("__mutmut_")[0].rpartition(".")[2]


def choose(root: Path, copy: Path, count: int, since: str) -> dict[str, dict[str, object]]:
    """Mutants of each file that are planted, and how many it has."""
    chosen: dict[str, dict[str, object]] = {}
    for name in _mutated_files(root):
        names, hashes = mutants_of(copy, name)
        changed = changed_functions(root, name, since, hashes)
        if names:
            chosen[name] = {"of": len(names), "names": sample(names, changed, count, name)}
    return chosen


def _results(copy: Path) -> dict[str, int | None]:
    """Exit codes of mutants that were run, from the files that mutmut leaves."""
    metas = (copy / "mutants" / "src").rglob("*.py.meta")
    return {k: v for file in metas for k, v in json.loads(file.read_text())["exit_code_by_key"].items()}


def main() -> int:
    """Copy the project, choose mutants, and run those that were not run yet; bounded in time."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sample", type=int, default=20, help="mutants of a module at most; 0 for all")
    parser.add_argument("--seconds", type=float, default=3600.0, help="after which the run stops; the next goes on")
    parser.add_argument("--since", help="commit whose functions count as unchanged; the last one of docs/mutants.md")
    parser.add_argument("--only", nargs="+", default=["*"], help="patterns of modules, such as src/conrod/mjcf/*")
    asked = parser.parse_args()
    last = ["git", "log", "-1", "--format=%H", "--", PAGE]
    since = asked.since or subprocess.run(last, cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()
    if not copy_project(ROOT, COPY):
        print("copied the project anew: there are no results yet")
    generate(COPY)
    chosen = choose(ROOT, COPY, asked.sample, since)
    (COPY / CHOSEN).write_text(json.dumps(chosen, indent=1), encoding="utf-8")
    done = {name for name, code in _results(COPY).items() if code is not None}
    names = [n for file, one in chosen.items() if _matches(file, asked.only) for n in one["names"]]  # type: ignore[attr-defined]
    left = [name for name in names if name not in done]
    print(f"{len(names)} mutants of {len(chosen)} modules, {len(names) - len(left)} run before", flush=True)
    if not left:
        return 0
    return run_mutmut(COPY, left, asked.seconds)


def run_mutmut(copy: Path, names: list[str], seconds: float) -> int:
    """Plant mutants in a copy of the project, and print how many are left; mutmut's own output goes into a file.

    Returns:
        Its exit status; where a test fails without a defect, the end of its output is printed.
    """
    settings = copy / "pyproject.toml"
    text = settings.read_text(encoding="utf-8")
    if DEBUG not in text:  # else it does not say which test fails without a defect
        settings.write_text(text.replace(SECTION, f"{SECTION}\n{DEBUG}"), encoding="utf-8")
    log = copy / "mutmut.log"
    environment = _environment()
    if not (copy / "mutants" / DURATIONS).exists():  # then mutmut first runs all tests to see what each reaches
        environment[PASSED_BEFORE] = "1"
    command = [sys.executable, RUNNER, "run", "--max-children", str(os.cpu_count() or 2), *names]
    begin = time.monotonic()
    end = begin + seconds
    with log.open("w", encoding="utf-8") as output:
        process = subprocess.Popen(command, cwd=copy, env=environment, stdout=output, stderr=output)
        try:
            while process.poll() is None and time.monotonic() < end:
                with suppress(subprocess.TimeoutExpired):
                    process.wait(timeout=min(POLL, max(end - time.monotonic(), 0.0)))
                done = {name for name, code in _results(copy).items() if code is not None}
                print(f"{sum(name in done for name in names)} of {len(names)} planted", flush=True)
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
                print("stopped; `make mutants` goes on from here")
                process.wait(timeout=60)
    spent, minutes = resource.getrusage(resource.RUSAGE_CHILDREN), (time.monotonic() - begin) / 60.0
    print(f"planted in {minutes:.0f} min, {(spent.ru_utime + spent.ru_stime) / 60.0:.0f} min of CPU")
    if process.returncode:
        print(*log.read_text(encoding="utf-8", errors="replace").splitlines()[-SHOWN:], sep="\n")
    return process.returncode


if __name__ == "__main__":
    sys.exit(main())
