"""What `conrod recommend` prints.

`conrod recommend`.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence

import click

from conrod.cli import options
from conrod.cli import options as exit_status
from conrod.engines.presets import STOCK
from conrod.report.terminal import console
from conrod.studies.recommend.recommendation import Confirmation, Recommendation, Refusal, Rejected


def print_recommendations(found: Sequence[Recommendation | Refusal], allowed: Mapping[str, float]) -> None:
    """A block for each engine."""
    out = console()
    for answer in found:
        lines = _recommended(answer, allowed) if isinstance(answer, Recommendation) else _refused(answer, allowed)
        out.print("\n".join(lines) + "\n", markup=False, soft_wrap=True)


def _recommended(found: Recommendation, allowed: Mapping[str, float]) -> list[str]:
    preset = f" (the preset {found.preset!r})" if found.preset else ""
    errors = ", ".join(f"{q} {e:.1e} (allowed {allowed[q]:g})" for q, e in found.errors.items())
    timing = found.timing
    return [
        f"{found.engine}: {found.rule}, {found.cell.settings.steps_per_revolution} steps per revolution{preset}",
        f"  largest errors: {errors}; margin {found.margin:.2g}",
        f"  cost: {1e3 * timing.seconds_per_revolution:.3g} ms of CPU time a revolution on this machine, "
        f"as much as {timing.ratio:.3g} steps of the engine's reference loop",
        f"  confirmed: {'; '.join(_confirmed(c) for c in found.confirmations)}",
        *_rejected(found.rejected),
        *_stock(found, allowed),
        f"  carries by: {found.groups.in_words()}",
        "  to paste:",
        *(f"    {line}" for line in found.paste.splitlines()),
    ]


def _confirmed(confirmation: Confirmation) -> str:
    errors = ", ".join(f"{q} {e:.1e}" for q, e in (confirmation.errors or {}).items())
    return f"{confirmation.what} {errors}"


def _rejected(rejected: Sequence[Rejected]) -> list[str]:
    return [
        f"  cheaper, but not confirmed: {r.rule}, {r.steps_per_revolution} steps per revolution ({r.why})"
        for r in rejected
    ]


def _stock(found: Recommendation, allowed: Mapping[str, float]) -> list[str]:
    stock, words = found.stock, list[str]()
    if found.preset == STOCK:
        return ["  these are the stock settings"]
    for quantity, digits in stock.digits.items():
        if digits is None:
            words.append(f"no stock run is as cheap ({quantity})")
        else:
            words.append(f"{digits:+.1f} digits of {quantity} at equal cost")
    if stock.cost_factor is not None:
        words.append(f"stock settings cost {stock.cost_factor:.3g} times as much for the same tolerance")
    else:
        best = ", ".join(f"{q} {e:.1e}" for q, e in stock.best.items() if e > allowed[q])
        words.append("stock settings never get there" + (f" (at best {best})" if best else ""))
    return [f"  against stock: {'; '.join(words)}"]


def _refused(found: Refusal, allowed: Mapping[str, float]) -> list[str]:
    if found.why:
        return [f"{found.engine}: nothing qualifies: {found.why}"]
    over = ", ".join(f"{q} is {x:.3g} times what is allowed" for q, x in found.excess.items())
    errors = ", ".join(f"{q} {e:.1e} (allowed {allowed[q]:g})" for q, e in found.errors.items())
    why = over or "what the grid allows was not confirmed"
    return [
        f"{found.engine}: nothing qualifies: {why}",
        f"  nearest: {found.rule}, {found.steps_per_revolution} steps per revolution: {errors}",
        *_rejected(found.rejected),
    ]


@click.command()
@click.argument("scene")
@click.option("--position", type=float, metavar="E", help="Largest error of position, over the travel L.")
@click.option("--velocity", type=float, metavar="E", help="Largest error of velocity, over omega L.")
@click.option("--acceleration", type=float, metavar="E", help="Largest error of acceleration, over omega^2 L.")
@options.engine
@options.grid
@options.assignments
@options.runs
@options.retime
def recommend(
    scene: str,
    position: float | None,
    velocity: float | None,
    acceleration: float | None,
    engine: str | None,
    grid: str,
    assignments: tuple[str, ...],
    ledger: str | None,
    fresh: bool,
    jobs: int | None,
    cluster: str | None,
    cell_timeout: float | None,
    cell_memory: str | None,
    retime: bool,
) -> None:
    """The cheapest setting of each engine within all given tolerances, ready to paste.

    Runs that the grid needs and the ledger lacks are made first. What is printed was confirmed on runs that the grid
    does not contain: another start angle, five revolutions, speeds 10 % off; of an input that makes one pass, that
    pass backwards, and those speeds.

    Exit status 0: at least one engine has such a setting; 1: none has; 2: bad usage.
    """
    from conrod.cli.runner import Options, Runner
    from conrod.engines.rule import grid_named
    from conrod.studies.frame.files import naming
    from conrod.studies.frame.resolve_arguments import select_engines, select_scene
    from conrod.studies.recommend.choice import check_tolerances, recommend_for
    from conrod.studies.recommend.recommendation import Recommendation
    from conrod.studies.sweep.plan import plan_sweep

    allowed = check_tolerances({"position": position, "velocity": velocity, "acceleration": acceleration})
    name, chosen = select_scene(scene, assignments)
    plan = plan_sweep(name, chosen, select_engines(engine), grid_named(grid))
    with Runner.of(Options(ledger, fresh, jobs, cluster, cell_timeout, cell_memory, retime)) as runner:
        found = recommend_for(plan, allowed, runner)
    with naming("standard output"):
        print_recommendations(found, allowed)
    if not any(isinstance(answer, Recommendation) for answer in found):
        sys.exit(exit_status.FAILED)
