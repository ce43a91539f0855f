"""pytest plugin of conrod: the fixture `conrod_check` and its baselines. It imports conrod when the fixture is used."""

from __future__ import annotations

import hashlib
import itertools
import os
import re
import shlex
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import pytest

if TYPE_CHECKING:
    from conrod import Checked

# Keywords of `conrod.check`, which are also words of the marker, options and settings; of these, numbers and lists.
WORDS = (
    "scene", "engine", "preset", "steps_per_rev", "revolutions", "set", "tolerance", "drive", "crank", "point", "plane",
    "rotation", "crank_zero", "length_unit", "keyframe", "touching", "ctrl", "column", "unit", "estimate", "qualify",
)  # fmt: skip
COUNTS, LISTS = ("steps_per_rev", "revolutions"), ("set", "drive", "point", "ctrl", "column", "unit")
Kind: TypeAlias = tuple[str, Literal["string", "args", "bool"]]
KINDS: dict[str, Kind] = {**dict.fromkeys(LISTS, ("append", "args")), "qualify": ("store_true", "bool")}
LAW = "law"  # in the place of a tolerance: what the engine's own law allows
FOLDER, LONGEST = "conrod-baselines", 100  # characters of a file's name
NOTE = "conrod"  # of what a passed test has to say


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options and settings, one of each for every word."""
    group = parser.getgroup("conrod", "physics engines against exact motion")
    group.addoption("--conrod-regen-all", action="store_true", help="Write changed baselines again; tests pass.")
    group.addoption(
        "--conrod-force-regen", action="store_true", help="Write changed baselines again; their tests fail."
    )
    for word in WORDS:
        option, (action, kind) = word.replace("_", "-"), KINDS.get(word, ("store", "string"))
        group.addoption(f"--conrod-{option}", action=action, help=f"{option} of conrod_check, as of `conrod validate`.")
        parser.addini(f"conrod_{word}", f"The same as --conrod-{option}.", type=kind, default=None)


def pytest_configure(config: pytest.Config) -> None:
    """Register the marker."""
    config.addinivalue_line("markers", f"conrod(**words): words of conrod_check for a test: {', '.join(WORDS)}.")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """What tests that passed have to say: other bits, baselines that were written again."""
    reports = itertools.chain.from_iterable(terminalreporter.stats.values())
    calls = [one for one in reports if isinstance(one, pytest.TestReport) and one.when == "call"]
    notes = [(one.nodeid, text) for one in calls for name, text in one.user_properties if name == NOTE]
    if notes:
        terminalreporter.section("conrod")
        for nodeid, text in notes:
            terminalreporter.write_line(f"{nodeid}: {text}")


@pytest.fixture
def conrod_check(request: pytest.FixtureRequest) -> Callable[..., Checked]:
    """Hold a scene, a model or a table to the law of its engine, and to the baseline beside the test.

    `conrod_check(subject, scene=None, tolerance="law", ...)`: arguments as of `conrod.check`, which are also words of
    the marker `conrod`, options (`--conrod-engine`) and settings (`conrod_engine`); an argument goes before the marker,
    that before an option, and that before a setting. Returns what `conrod.check` does.
    """
    files = _files(request)

    def check(subject: Any, scene: Any = None, **words: Any) -> Checked:
        __tracebackhide__ = True
        given = words if scene is None else {"scene": scene, **words}
        return _checked(request, subject, given, next(files))

    return check


def _checked(request: pytest.FixtureRequest, subject: Any, given: dict[str, Any], file: Path) -> Checked:
    __tracebackhide__ = True
    import conrod
    from conrod.studies.frame.baseline import OtherBaseline

    forced, accepted = (request.config.getoption(f"--conrod-{one}") for one in ("force-regen", "regen-all"))
    try:
        words = _words(request, given)
        # Models with driven joints are held to their exact motion alone.
        baseline = {} if "drive" in words else {"baseline": file, "accept": forced or accepted}
        checked = conrod.check(subject, words.pop("scene", None), **words, **baseline)
    except conrod.InvalidInput as error:
        accept = f"\naccept: {_command(request)}" if isinstance(error, OtherBaseline) else ""
        raise pytest.fail.Exception(f"conrod: {error}{accept}", pytrace=False) from None
    held = checked.baseline
    failed = [f"out of the law: {checked.verdict}"] if checked.in_law is False else []
    if held is not None and (not held.passed or (forced and held.written)):
        failed.append(held.text)
        if not held.written and checked.in_law is not False:
            failed.append(f"accept: {_command(request)}")
    if failed:
        pytest.fail("conrod: " + "\n".join(failed), pytrace=False)
    if held is not None and held.text:
        request.node.user_properties.append((NOTE, held.text))
    return checked


def _words(request: pytest.FixtureRequest, given: dict[str, Any]) -> dict[str, Any]:
    """What is asked for, by the word; raises InvalidInput for one that there is not."""
    from conrod.errors import InvalidInput, unknown_choice

    config, words = request.config, dict[str, Any]()
    for word in WORDS:
        option, setting = config.getoption(f"--conrod-{word.replace('_', '-')}"), config.getini(f"conrod_{word}")
        if value := option or setting:
            words[word] = value
    for mark in (*reversed(list(request.node.iter_markers("conrod"))), pytest.mark.conrod(**given).mark):
        if mark.args:
            raise InvalidInput(f"@pytest.mark.conrod({mark.args[0]!r}): give words, e.g. engine='mujoco'")
        words |= {"point" if word == "points" else word: value for word, value in mark.kwargs.items()}
    for word, value in words.items():
        if word not in WORDS:
            raise unknown_choice("word of conrod_check", word, WORDS)
        if word in COUNTS and isinstance(value, str):
            if not value.isdecimal():
                raise InvalidInput(f"{word} = {value!r}: give a whole number")
            words[word] = int(value)
    return {word: value for word, value in words.items() if (word, value) != ("tolerance", LAW)}


def _files(request: pytest.FixtureRequest) -> Iterator[Path]:
    """Baselines of a test, one for each check that it makes: in a folder of its module's name beside that."""
    module, name = request.path, request.node.nodeid.partition("::")[2]
    function, _, parameters = name.removesuffix("]").partition("[")
    plain = "-".join(filter(None, [function.replace("::", "-"), parameters]))
    if len(plain) > LONGEST or not re.fullmatch(r"[\w.-]+", plain, re.ASCII):
        digest = hashlib.sha256(name.encode()).hexdigest()[:8]
        plain = re.sub(r"[^\w.-]+", "-", plain)[:LONGEST] + f"-{digest}"
    for k in itertools.count(1):
        yield Path(_short(module.parent / FOLDER / module.stem / f"{plain}{'' if k == 1 else f'+{k}'}.json"))


def _short(path: Path) -> str:
    return min(str(path), os.path.relpath(path), key=len)


def _command(request: pytest.FixtureRequest) -> str:
    test = "::".join([_short(request.path), request.node.nodeid.partition("::")[2]])
    return f"pytest --conrod-regen-all {shlex.quote(test)}"
