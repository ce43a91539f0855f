"""Chains of parallelogram four-bars in free swing, of any length: `four-bar-chain-N`.

The N-four-bar problem of the IFToMM library of computational benchmark problems: it has one degree of freedom but where
all links lie in one line, where it gains N more.
"""

from __future__ import annotations

from conrod.errors import InvalidInput

CHAIN = "four-bar-chain-"
LEAST, MOST = 2, 40  # a mechanism file has 100 bodies at most

_HEAD = """name = "{chain}{count}"
title = "Chain of {count} parallel four-bars in free swing"
source = "the benchmark N-four-bar of the IFToMM library of computational benchmark problems"
description = \"\"\"
{rockers} rockers of 1 m, upright, 1 m from each other, with a bar from each tip to the next. The first tip starts \\
with 1 m/s to the right, and all turn over and over under their weight. Lying flat, twice a turn, every four-bar \\
could go on crossed; the motion is the smooth continuation, on which all rockers turn alike and no bar turns: one \\
pendulum.\"\"\"
assumptions = [
    "links are uniform bars of 1 kg, as in the benchmark",
    "the crank's pass at constant speed ends before the rockers lie flat; the free motion does not",
]
frame = "the first rocker's pivot is at (0, 0), the others on +x; y is up; crank angles count clockwise from upright"
gravity = [0, "-9.81 m/s^2"]
output = "tip"

[driver]
joint = "pivot0"
speed = "1 rad/s"
sense = "clockwise"
start = "90 deg"
from = "-80 deg"
to = "80 deg"

[ground.points]
"""
_BAR = """
[bodies.{name}]
points = {{ A = [0, 0], B = ["1 m", 0] }}
uniform = "bar"
mass = "1 kg"
"""


def chain_count(name: str) -> int | None:
    """Number of four-bars of the chain of a name; None of a name that is no chain's.

    Raises:
        InvalidInput: there is no chain of that length.
    """
    digits = name.removeprefix(CHAIN)
    if digits == name or not (digits.isascii() and digits.isdigit()) or digits.startswith("0"):
        return None
    count = int(digits) if len(digits) < len(str(MOST)) + 1 else MOST + 1
    if not LEAST <= count <= MOST:
        raise InvalidInput(f"{name}: chains have from {LEAST} to {MOST} four-bars")
    return count


def chain_text(count: int) -> str:
    """The mechanism file of a chain.

    Raises:
        InvalidInput: the count is out of range.
    """
    if not LEAST <= count <= MOST:
        raise InvalidInput(f"a chain of {count} four-bars: from {LEAST} to {MOST} are wanted")
    rockers, bars = range(count + 1), range(count)
    joints = [f'pivot{i} = {{ kind = "revolute", connects = ["ground.O{i}", "rocker{i}.A"] }}' for i in rockers]
    for i in bars:
        joints.append(f'left{i} = {{ kind = "revolute", connects = ["rocker{i}.B", "bar{i}.A"] }}')
        joints.append(f'right{i} = {{ kind = "revolute", connects = ["bar{i}.B", "rocker{i + 1}.B"] }}')
    lines = [
        *(f"O{i} = [{i}, 0]" for i in rockers),
        *(_BAR.format(name=f"rocker{i}").rstrip("\n") for i in rockers),
        *(_BAR.format(name=f"bar{i}").rstrip("\n") for i in bars),
        "\n[joints]",
        *joints,
        "\n[start]",
        *(f"bar{i} = {{ turn = 0 }}" for i in bars),
        '\n[observed]\ntip = "rocker0.B"',
    ]
    return _HEAD.format(chain=CHAIN, count=count, rockers=count + 1) + "\n".join(lines) + "\n"
