"""`conrod init`."""

from __future__ import annotations

import shlex

import click

from conrod.cli import options, say


@options.verb()
@click.argument("folder", default=".", metavar="[FOLDER]", type=click.Path(file_okay=True))
def init(folder: str) -> None:
    """Begin a project in FOLDER: a commented mechanism file, a test and a workflow.

    Nothing that is there is overwritten.
    """
    from conrod.guide.init.api import begin_project

    mechanism, test, workflow = begin_project(folder)
    validate, run = (
        shlex.join(("conrod", "validate", str(mechanism))),
        shlex.join(("python", "-m", "pytest", str(test))),
    )
    say(f"{mechanism}: the machine, to be changed into yours; next: {validate}")
    say(f"{test}: its test; next: pip install pytest; {run}, whose first run writes the baselines")
    say(f"{workflow}: the same on a build server")
