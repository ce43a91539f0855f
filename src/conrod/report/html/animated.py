"""The machine in motion as an SVG of its own, which moves wherever pictures do and is a picture where they do not."""

from __future__ import annotations

import re

import numpy as np

from conrod.exact.motion import Array
from conrod.report.html.moving import POSES, Moving

FRAMES = 48  # of a turn
SECONDS = 6.0  # for a turn
STYLE = """svg{--ink:#222;--faint:#777;--part:#dde6ec;--ground:#fff;--raised:#f2f2f2}.ghost{color:#8a949e;opacity:.4}
.engine{color:#2673b8}@media(prefers-color-scheme:dark){svg{--ink:#e4e8ec;--faint:#a3adb8;--part:#2c3944;--ground:#14181c;
--raised:#1e242a}.engine{color:#79b8f2}}"""


def animated_svg(machine: Moving) -> str:
    """The first run's machine over the exact one, its error magnified to be visible."""
    run, bodies = machine.runs[0], list(machine.drawing.bodies.values())
    exact, errors = machine.exact[:: POSES // FRAMES], machine.errors(run)
    rows = np.round(np.linspace(0, len(errors) - 1, len(exact))).astype(int)
    engine = exact + 10.0 ** machine.power(run) * errors[rows]
    still = round(machine.still * FRAMES / POSES)
    shapes = "".join(f'<g id="b{k}">{body}</g>' for k, body in enumerate(bodies[:-1]))
    moved = "".join(f'<g class="{name}">{_moved(p, still)}</g>\n' for name, p in (("ghost", exact), ("engine", engine)))
    left, top, width, height = machine.drawing.box
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{left:.0f} {top:.0f} {width:.0f} {height:.0f}" width="640" '
        f'height="{640 * height / width:.0f}"><style>{STYLE}</style><defs>{shapes}</defs>\n'
        f"{bodies[-1]}\n{moved}</svg>\n"
    )


def inline(svg: str, prefix: str) -> str:
    """A drawing of `animated_svg` as part of a page that has its styles, with ids that no other has."""
    shapes = re.sub("<style>.*?</style>", "", svg, flags=re.DOTALL)
    shapes = shapes.replace("<svg ", '<svg aria-hidden="true" ', 1)
    return shapes.replace('id="b', f'id="{prefix}b').replace('href="#b', f'href="#{prefix}b')


def _moved(poses: Array, still: int) -> str:
    """Each body's shapes at its poses, one after the other; where nothing moves at one of them."""
    found = ""
    for k, body in enumerate(np.split(poses, poses.shape[1] // 3, axis=1)):
        places = ";".join(f"{x:.1f} {y:.1f}" for x, y, _ in body)
        turns = ";".join(f"{turn:.2f}" for *_, turn in body)
        x, y, turn = body[still]
        found += (
            f'<g transform="translate({x:.1f} {y:.1f})">{_animation("translate", places)}'
            f'<g transform="rotate({turn:.2f})">{_animation("rotate", turns)}<use href="#b{k}"/></g></g>'
        )
    return found


def _animation(kind: str, values: str) -> str:
    return (
        f'<animateTransform attributeName="transform" type="{kind}" values="{values}" dur="{SECONDS:.0f}s" '
        'repeatCount="indefinite"/>'
    )
