"""What `conrod harden` prints."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.table import Table

from conrod.cli.console import console
from conrod.mjcf.harden.results import HardenedModel, Orders, Touching, Variant

MOST_LOOPS = 12
ALWAYS = (
    "mj_setConst makes the weights anew and so undoes this: say the lines again after it, or after changing masses "
    "in a way that calls it",
    "for double precision only: in single precision (MJX, Warp, a float32 build) keep the model as it is",
    "a binary model is read by the version of MuJoCo that wrote it; the lines above are for every version",
)


def print_hardened(found: HardenedModel, file: Path | None) -> None:
    """Figures before and after, lines to paste, and what to know; or why there are none."""
    out = console()
    if found.variants:
        _print_figures(out, found)
    if found.lines and not found.refusals:
        out.print("\nin Python:\n")
        out.print(found.lines, markup=False, soft_wrap=True)
    for refusal in found.refusals:
        out.print(f"[yellow]not hardened[/]: {_plain(refusal)}", soft_wrap=True)
    for warning in found.warnings:
        out.print(f"[yellow]note[/]: {_plain(warning)}", soft_wrap=True)
    if found.refusals:
        return
    for note in ALWAYS:
        out.print(f"note: {note}", markup=False, soft_wrap=True)
    told = f"the hardened model: {file}" if file else "nothing written: -o FILE.mjb writes the model"
    out.print(told, markup=False, soft_wrap=True)


def _print_figures(out: Console, found: HardenedModel) -> None:
    out.print(
        f"{found.path}: MuJoCo {found.mujoco}, {found.seconds:.4g} s in steps of {found.timestep:g} s from "
        f"{found.start}; size {found.size:.4g} m",
        markup=False,
        soft_wrap=True,
    )
    opened = ", ".join(f"{value:.1e} {unit}" for unit, value in (found.start_opening or {}).items())
    begin = "the runs start with them closed" if found.start_closed else "and so the runs start"
    out.print(f"its loops are open by {opened} there; {begin}\n", markup=False, soft_wrap=True)
    table = Table(title="largest in the run", title_justify="left")
    table.add_column("")
    for variant in found.variants:
        table.add_column(variant.name, justify="right")
    for row in _rows(found):
        table.add_row(*row)
    out.print(table)
    for line in _reading(found):
        out.print(line, markup=False, soft_wrap=True)


def _rows(found: HardenedModel) -> list[list[str]]:
    variants = found.variants
    rows = [["steps completed", *(_completed(v) for v in variants)]]
    for k, loop in enumerate(found.loops[:MOST_LOOPS]):
        values = (None if v.openings is None else v.openings[k] for v in variants)
        rows.append([_plain(f"opening of {loop.kind} {loop.name} [{loop.unit}]"), *map(_figure, values)])
    if len(found.loops) > MOST_LOOPS:
        rows.append([f"... and {len(found.loops) - MOST_LOOPS} loops more (--json has them)", *[""] * len(variants)])
    rows.append(["largest opening over size", *(_figure(v.opening_over_size) for v in variants)])
    rows.append(["  order in the step", *(_orders(v.closing) for v in variants)])
    rows.append([_plain("drift from the reference [m]"), *(_drift(found, v.drift) for v in variants)])
    rows.append(["  order in the step", *(_orders(v.drift) for v in variants)])
    rows.append(["energy, change over exchanged", *(_figure(v.energy) for v in variants)])
    if any(v.touching and (v.touching.contacts or v.touching.limits) for v in variants):
        rows.append([_plain("contacts at once, penetration [m]"), *(_contacts(v.touching) for v in variants)])
        rows.append([_plain("limits passed at once, by [rad, m]"), *(_limits(v.touching) for v in variants)])
    rows.append(["solver iterations", *("-" if v.iterations is None else f"{v.iterations:.1f}" for v in variants)])
    return rows


def _reading(found: HardenedModel) -> list[str]:
    """What the figures are."""
    lines = []
    if found.reference_known_to is None:
        lines.append("drift: none told, the reference (hardened, RK4, a sixteenth of the step) breaks off")
    else:
        lines.append(
            "drift: of any body's centre of gravity, from the hardened model under RK4 at a sixteenth of the step, "
            f"which is known to {found.reference_known_to:.1e} m (-: less than that); travel {found.travel:.3g} m"
        )
    without = (
        f"of copies without {', '.join(found.energy_without)}" if found.energy_without else "nothing takes or gives any"
    )
    lines.append(f"energy: {without}" + (f"; none told: {found.energy_note}" if found.energy_note else ""))
    lines.append(f"weights: times {found.factor:g} for {', '.join(found.scaled)}")
    lines.append(f"harden with them: {', '.join(found.touching_scaled) or 'no geom that collides, no limit'}")
    if found.cost is not None:
        cost = found.cost
        lines.append(
            f"cost of a step, hardened over as it is: {cost.ratio:.2f} (quartiles {cost.low:.2f} to {cost.high:.2f}), "
            f"{1e6 * cost.seconds:.3g} us on this machine"
        )
    return lines


def _completed(variant: Variant) -> str:
    return str(variant.steps) if variant.broke is None else f"[red]{variant.steps}[/], then {variant.broke}"


def _orders(orders: Orders | None) -> str:
    if orders is None:
        return "-"
    if orders.claimed is not None:
        return f"{orders.claimed:.2f}"
    if all(pair is None for pair in orders.pairs):
        return "-"
    return ", ".join("-" if pair is None else f"{pair:z.1f}" for pair in orders.pairs)


def _drift(found: HardenedModel, drift: Orders | None) -> str:
    if drift is None or found.reference_known_to is None or drift.values[0] <= found.reference_known_to:
        return "-"
    return _figure(drift.values[0])


def _contacts(touching: Touching | None) -> str:
    return "-" if touching is None else _counted(touching.contacts, touching.penetration)


def _limits(touching: Touching | None) -> str:
    return "-" if touching is None else _counted(touching.limits, touching.excess)


def _counted(number: int, most: float) -> str:
    return f"{number}, {most:.1e}" if number else "none"


def _figure(value: float | None) -> str:
    return "-" if value is None else f"{value:.1e}"


def _plain(text: str) -> str:
    """Text in which nothing is markup."""
    from rich.markup import escape

    return escape(text)
