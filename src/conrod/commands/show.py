"""`conrod show`."""

from __future__ import annotations

from pathlib import Path

import click

from conrod.commands import options
from conrod.errors import InvalidInput


@click.command()
@click.argument("scene", required=False)
@options.assignments
@click.option("--svg", "drawing", metavar="FILE", help="Draw the scene to an SVG file.")
def show(scene: str | None, assignments: tuple[str, ...], drawing: str | None) -> None:
    """What there is, one line each; or all about one SCENE."""
    from conrod.console import show_catalogue, show_scene
    from conrod.selection import select_scene

    if scene is None:
        if drawing is not None or assignments:
            raise InvalidInput("--svg and --set need a SCENE; `conrod show` lists them")
        show_catalogue()
        return
    file = None if drawing is None else _drawing_file(drawing)
    name, chosen = select_scene(scene, assignments)
    show_scene(name, chosen)
    if file:
        from conrod.report.drawing import draw_mechanism

        draw_mechanism(chosen, file)
        click.echo(f"drawing: {file}")


def _drawing_file(text: str) -> Path:
    from conrod.files import file_to_write

    if text.strip() and not text.lower().endswith(".svg"):
        raise InvalidInput(f"--svg {text}: the drawing is SVG: give a name that ends in .svg")
    return file_to_write(text, "--svg")
