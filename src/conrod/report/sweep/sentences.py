"""Findings of a sweep in sentences made from its numbers; a sentence whose numbers are missing is left out."""

from __future__ import annotations

from collections.abc import Iterator

from conrod.engines.presets import STOCK
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.markdown import listed
from conrod.report.sweep.bands import Row, preset_rows, rows_of
from conrod.report.sweep.selection import (
    Among,
    cheapest_within,
    most_accurate,
    preset_curves,
    setting_of,
    timed_engines,
    tolerance,
    with_unit,
)
from conrod.report.sweep.tables import variation_name
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.findings import COMPLETED, SweepStudy, SweptPoint
from conrod.studies.sweep.sensitivity import Sensitivity

QUANTITY, ALLOWED = "position", 1e-6
APART = 0.5  # orders that differ by more are different ones


def sentences(study: SweepStudy) -> list[str]:
    """The main findings, one paragraph each: what accuracy costs, and where it ends."""
    return [*_economies(study), *_plateaus(study)]


def more_sentences(study: SweepStudy) -> list[str]:
    """Causes of the errors, and whether a study of convergence alone would have noticed them."""
    return [
        *_causes(study),
        *_dependences(study),
        *_unnoticed(study),
        *_shares(study),
        *_knob_orders(study),
    ]


# -- costs -------------------------------------------------------------------------------------------------------------


def _economies(study: SweepStudy) -> Iterator[str]:
    """For each engine with timings: the cheapest setting within the tolerance, and the cheapest of other kinds."""
    for engine in timed_engines(study):
        best = cheapest_within(study, QUANTITY, ALLOWED, engine)
        if best is not None:
            yield _cheapest(study, engine, best)
            continue
        nearest = most_accurate(study, QUANTITY, engine)
        least = (
            f" The least is {with_unit(nearest.error(QUANTITY), QUANTITY)}: {setting_of(nearest)}." if nearest else ""
        )
        title = engine_title(engine)
        yield f"**No setting of {title} in the grid reaches a {QUANTITY} error of {tolerance(ALLOWED)}.**{least}"


def _cheapest(study: SweepStudy, engine: str, best: SweptPoint) -> str:
    parts = [
        f"**The cheapest setting of {engine_title(engine)} for a {QUANTITY} error of {tolerance(ALLOWED)}** is "
        f"{setting_of(best)}: {numbers.duration(best.cost)} of CPU time a revolution."
    ]
    for words, among in _kinds(study, best).items():
        if any(p.engine == engine and among(p) for p in study.points):
            other = cheapest_within(study, QUANTITY, ALLOWED, engine, among)
            parts.append(_compared(best, words, other))
    own = [p.error(QUANTITY) or 0.0 for p in study.points if (p.engine, p.preset) == (engine, STOCK) and p.completed]
    if own and min(own) > ALLOWED:
        parts.append(f"The {STOCK} settings never get there: their least error is {with_unit(min(own), QUANTITY)}.")
    return " ".join(parts)


def _kinds(study: SweepStudy, best: SweptPoint) -> dict[str, Among]:
    """Other kinds of settings than the best one: an integrator of first order, another regularisation."""
    rule, kinds = study.rule_of(best), dict[str, Among]()
    if rule.formal_order is not None and rule.formal_order > 1.0:
        kinds["with an integrator of first order"] = lambda p: study.rule_of(p).formal_order == 1.0
    if regularisation := rule.knobs.get("regularisation", "").partition(" ")[0]:
        kinds[f"whose regularisation is not {regularisation}"] = lambda p: (
            not study.rule_of(p).knobs.get("regularisation", regularisation).startswith(regularisation)
        )
    return kinds


def _compared(best: SweptPoint, words: str, other: SweptPoint | None) -> str:
    if other is None:
        return f"No setting {words} reaches it."
    factor = (other.cost or 0.0) / (best.cost or 1.0)
    cost = f"{numbers.duration(other.cost)}, **{numbers.measured(factor)} times as much**"
    return f"The cheapest {words} is {setting_of(other)}: {cost}."


# -- plateaus and causes -----------------------------------------------------------------------------------------------


def _plateaus(study: SweepStudy) -> Iterator[str]:
    rules = {(rule.engine, rule.name): rule for rule in study.rules}
    for curve in preset_curves(study):
        rule = rules.get((curve.engine, curve.rule))
        if rule is None or curve.preset != STOCK:
            continue
        levels = {q: rule.orders[q].plateau for q in QUANTITIES}
        stuck = [f"the {q} error at {with_unit(level, q)}" for q, level in levels.items() if level is not None]
        if stuck:
            finest = max(p.steps_per_revolution for p in study.points_of(rule) if p.completed)
            yield (
                f"**The {curve.preset} settings of {engine_title(curve.engine)} stop getting better** ({rule.name}). "
                f"Refining the step alone, up to {finest} steps per revolution, leaves {listed(stuck)}: no smaller "
                "step helps."
            )


def _causes(study: SweepStudy) -> Iterator[str]:
    """Parts of the baselines' position error, as far as all runs that separate them completed."""
    for budget in (b for b in study.budgets if b.preset == STOCK):
        norms = {part.name: part.norms["position"] for part in budget.parts if part.norms is not None}
        if not {"total", "iteration", "step", "model"} <= norms.keys():
            continue
        model = budget.part("model")
        named = model.named and norms["model"].resolved
        law = f", where the engine's documented law gives {with_unit(model.predicted, 'position')}" * named
        sizes = {
            name: with_unit(norm.max, "position") if norm.resolved else "nothing that is resolved"
            for name, norm in norms.items()
        }
        yield (
            f"**What {engine_title(budget.engine)}'s {budget.preset} error is made of.** Of {sizes['total']} in "
            f"position, the model's softness alone makes {sizes['model']}{law}; the step {sizes['step']}; the "
            f"iteration {sizes['iteration']} ({budget.settings.get('steps_per_revolution')} steps per revolution)."
        )


# -- masses and gravity ------------------------------------------------------------------------------------------------


def _dependences(study: SweepStudy) -> Iterator[str]:
    """By how much the errors of each preset depend on masses and gravity, of which the exact motion is free."""
    for engine in study.engines:
        presets = [phrase for s in study.sensitivities if s.engine == engine and (phrase := _dependence(s))]
        if presets:
            yield (
                f"**How {engine_title(engine)}'s errors depend on masses and gravity**, on which the exact motion does "
                f"not: {'; '.join(presets)}."
            )


def _dependence(sensitivity: Sensitivity) -> str:
    # Where the drive faltered, a change is not the joints'.
    changed = [v for v in sensitivity.variations[1:] if v.outcome != COMPLETED or v.drive_kept]
    ratios = [r for v in changed for q in QUANTITIES if (r := v.ratios.get(q))]
    failed = [f"{variation_name(sensitivity, v)} (`{v.outcome}`)" for v in changed if v.outcome != COMPLETED]
    if not ratios:
        return ""
    factor = max(max(ratio, 1.0 / ratio) for ratio in ratios)
    besides = f", and with {listed(failed)} it does not complete" if failed else ""
    return f"`{sensitivity.preset}` changes by a factor of at most {numbers.measured(factor)}{besides}"


# -- grid convergence index, and orders --------------------------------------------------------------------------------


def _unnoticed(study: SweepStudy) -> Iterator[str]:
    for row in preset_rows(study):
        position = row.shares["position"]
        if row.title != STOCK or position.share is None:
            continue
        lead = "would not have noticed" if position.share < 0.5 else "would have noticed"
        shares = {q: found.share for q, found in row.shares.items() if found.share is not None and q != "position"}
        others = [f"{numbers.percent(share)} for {q}" for q, share in shares.items()]
        ratio = f" The band is {numbers.measured(position.ratio)} of the error (median)." if position.ratio else ""
        yield (
            f"**{engine_title(row.engine)}, {row.title}: refining the {row.path}, a study of convergence alone "
            f"{lead}.** The band of the grid convergence index holds the true position error in "
            f"{numbers.percent(position.share)} of {position.judged} cells"
            f"{f' ({listed(others)})' if others else ''}.{ratio}"
        )


def _shares(study: SweepStudy) -> Iterator[str]:
    for engine in study.engines:
        rows = [(row, words) for row in rows_of(study) if row.engine == engine and (words := _of_quantities(row))]
        if rows:
            parts = "; ".join(f"refining the {row.path}, in {words}" for row, words in rows)
            yield (
                f"**How often that band can be trusted, {engine_title(engine)}**, over all settings that differ in "
                f"effect: it holds the true error, {parts}."
            )


def _of_quantities(row: Row) -> str:
    shares = [(q, found.share) for q, found in row.shares.items() if found.share is not None]
    return listed([f"{numbers.percent(share)} of the cells ({q})" for q, share in shares]) if shares else ""


def _knob_orders(study: SweepStudy) -> Iterator[str]:
    """Knobs that alone decide on the order of position, the stock one against another: the last rules that show it."""
    stock = {c.engine: study.rule_of(c.points[0]).knobs for c in preset_curves(study) if c.preset == STOCK}
    claimed = [(rule, order) for rule in study.rules if (order := rule.orders[QUANTITY].claimed) is not None]
    for engine, usual in stock.items():
        own, found = [pair for pair in claimed if pair[0].engine == engine], dict[str, str]()
        for one, first in own:
            for other, second in own:
                changed = [k for k in {**one.knobs, **other.knobs} if one.knobs.get(k) != other.knobs.get(k)]
                if len(changed) == 1 and abs(first - second) > APART:
                    (knob,) = changed
                    if one.knobs.get(knob) == usual.get(knob):
                        found[knob] = (
                            f"with `{knob}` at {one.knobs.get(knob)} its position error falls at order "
                            f"{numbers.order(first)} ({one.name}), at {other.knobs.get(knob)} at order "
                            f"{numbers.order(second)} ({other.name})"
                        )
        if found:
            yield f"**What the order of {engine_title(engine)} depends on**: {'; '.join(found.values())}."
