"""Copies of MuJoCo models with something wrong in them, and what a verb makes of one."""

from __future__ import annotations

import copy
import os
import random
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch
from xml.etree import ElementTree

from mutants import FACTORS, SLIPS, break_text, quantity

from tests.support.command_line import conrod

Element = ElementTree.Element
ROOT = Path(__file__).parents[2]
HACKSAW = ROOT / "tests/support/own_models/hacksaw.xml"
# Each model, with what `check` is to be told of it.
MODELS = {
    ROOT / "mjcf/saw-500rpm.xml": ("--scene", "saw-500rpm", "--crank", "crank", "--point", "C=body:slider"),
    ROOT / "mjcf/shear-press.xml": ("--scene", "shear-press", "--crank", "crank", "--point", "A=site:A"),
    ROOT / "mjcf/cam-follower.xml": ("--scene", "cam-follower", "--crank", "crank", "--point", "roller=site:roller"),
    HACKSAW: ("--scene", "saw-500rpm", "--crank", "motor", "--point", "C=body:bow"),
}
SHORT = ("--seconds", "0.05")
QUICK = "conrod.execution.paired_timing.BLOCK_TIME", 2e-5  # [s], of harden's timing, which is not at stake
FEWER = 10  # one vertex of a cam in so many is kept, and its two tips: compiling it costs less
VERBS = ("lint", "harden", "check")

# -- changes ---------------------------------------------------------------------------------------------------------


def _attribute(root: Element, chance: random.Random) -> tuple[Element, str]:
    return chance.choice([(element, name) for element in root.iter() for name in element.attrib])


def number(root: Element, chance: random.Random) -> None:
    """One number becomes another one, or a multiple of itself."""
    found = [
        (e, name, k)
        for e in root.iter()
        for name in e.attrib
        for k, w in enumerate(e.attrib[name].split())
        if quantity(w)
    ]
    element, name, k = chance.choice(found)
    words = element.attrib[name].split()
    words[k] = repr(chance.choice(SLIPS) if chance.random() < 0.3 else float(words[k]) * chance.choice(FACTORS))
    element.set(name, " ".join(words))


def attribute_lost(root: Element, chance: random.Random) -> None:
    element, name = _attribute(root, chance)
    del element.attrib[name]


def _child(root: Element, chance: random.Random) -> tuple[Element, Element]:
    return chance.choice([(parent, child) for parent in root.iter() for child in parent])


def element_lost(root: Element, chance: random.Random) -> None:
    parent, child = _child(root, chance)
    parent.remove(child)


def element_twice(root: Element, chance: random.Random) -> None:
    """Duplicate an element, with the same names or without names."""
    parent, child = _child(root, chance)
    again = copy.deepcopy(child)
    for element in again.iter() if chance.random() < 0.5 else ():
        element.attrib.pop("name", None)
    parent.append(again)


TREE_CHANGES: tuple[Callable[[Element, random.Random], None], ...] = (
    *(5 * (number,)),  # most of what the others make is not loaded
    attribute_lost,
    element_lost,
    element_twice,
)


def mutant(path: Path, seed: str) -> bytes:
    """The changed copy of a model that a seed determines."""
    chance, root = random.Random(f"{path.name} {seed}"), ElementTree.fromstring(path.read_bytes())
    for mesh in root.iter("mesh"):
        words = mesh.attrib["vertex"].split()
        kept = [word for k, word in enumerate(words[:-6]) if k // 3 % FEWER == 0]
        mesh.set("vertex", " ".join(kept + words[-6:]))
    if chance.random() < 0.1:
        return break_text(ElementTree.tostring(root), chance)
    for _ in range(chance.choice((1, 1, 1, 2))):
        chance.choice(TREE_CHANGES)(root, chance)
    return ElementTree.tostring(root)


# -- what becomes of them --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class End:
    """How a command ended.

    Attributes:
        status: exit status; -1 for what a user would see as a fault of conrod.
        wrong: what a user must not see; "" for nothing.
        seconds: CPU time [s].
    """

    status: int
    wrong: str
    seconds: float


def call_in_process(task: Callable[..., Any], path: Path, *arguments: Any, **limits: Any) -> Any:
    return task(path, *arguments)


def attempt(base: Path, seed: str, verb: str, folder: Path) -> End:
    """Run a verb on a mutant, and return how it ended."""
    file = folder / f"{os.getpid()}-{base.name}"
    file.write_bytes(mutant(base, seed))
    options = (*MODELS[base], "--revolutions", "1") if verb == "check" else SHORT
    begun = time.process_time()
    try:
        done = conrod(verb, file.name, *options, cwd=folder)
    except Exception:
        return End(-1, traceback.format_exc(), time.process_time() - begun)
    lines = [line for line in done.stderr.splitlines() if line]
    refused = done.returncode != 2 or (len(lines) == 1 and lines[0].startswith("conrod: ") and len(lines[0]) < 420)
    known = done.returncode in (0, 1, 2) and "Traceback" not in done.stdout + done.stderr
    return End(int(done.returncode), "" if refused and known else done.stderr[-2000:], time.process_time() - begun)


def attempt_here(base: Path, seed: str, verb: str, folder: Path) -> End:
    """The same in the process that calls, where it costs no start of Python."""
    with patch("conrod.execution.local.call_on_file", call_in_process), patch(*QUICK):
        return attempt(base, seed, verb, folder)
