"""A sweep made by hand: few points with round numbers, two failures, a budget, a sensitivity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from conrod.scenes import SCENES
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.frame.timing import Timing
from conrod.studies.sweep.error_budget import ErrorBudget, Norm, Part
from conrod.studies.sweep.grid_convergence import GridConvergence, GridTriple, Share
from conrod.studies.sweep.observed_orders import ObservedOrders, PathPoint, order_of
from conrod.studies.sweep.results import SweepStudy, SweptPoint
from conrod.studies.sweep.sensitivity import Sensitivity, Variation

STEPS = (20, 100, 500, 2500)

# -- a sweep made by hand: rule, knobs, preset, cost of a step [s], errors of position at STEPS ------------------------

STOCK = ("Euler, solref 0.02 s, solimp stock", {"integrator": "Euler", "regularisation": "stock"}, "stock", 2e-6)
HARD = ("RK4, solref T/10, hardened 1e-9", {"integrator": "RK4", "regularisation": "hardened 1e-9"}, "hardened", 8e-6)
FAST = ("implicitfast, solref 2 h", {"integrator": "implicitfast", "regularisation": "stiff"}, None, 2.6e-6)
BIASED = ("error_bias stock, 10 iterations", {"error_bias": "stock", "iterations": "10"}, "stock", 1e-6)
EXACT = ("error_bias 0, 10 iterations", {"error_bias": "0", "iterations": "10"}, "tuned", 1e-6)
RULES: Mapping[str, Sequence[tuple[Any, tuple[float | None, ...]]]] = {
    "mujoco": (
        (STOCK, (None, 0.041, 0.0402, 0.0401)),
        (HARD, (4e-4, 7e-7, 1.1e-9, 2e-12)),
        (FAST, (4e-3, 1.6e-4, 6.4e-6, 2.6e-7)),
    ),
    "pymunk": ((BIASED, (None, 0.04, 0.008, 0.0016)), (EXACT, (0.025, 1e-3, 4e-5, 1.6e-6))),
}


def measurement(error: float | None) -> Measurement:
    if error is None:
        return Measurement("opened", "the loop is open")
    sizes = {"position": error, "velocity": 2.0 * error, "acceleration": 3.0 * error, "total": error}
    return Measurement(
        "completed",
        errors={"C": {q: {"max": e, "rms": e / 2.0, "final": e / 3.0} for q, e in sizes.items()}},
        prediction={q: {"predicted": sizes[q], "difference": sizes[q] ** 2} for q in QUANTITIES},
    )


def points(engine: str) -> list[SweptPoint]:
    found: list[SweptPoint] = []
    for (rule, knobs, preset, step), errors in RULES[engine]:
        for n, error in zip(STEPS, errors, strict=True):
            label = f"{engine[0].upper()}{len(found) + 1}"
            # What a failed run cost must not be believed: it is made absurd here.
            seconds = 1e3 if error is None else step * n
            timing = Timing(seconds, 1e-6, seconds / 1e-6, n, 3, "a machine")
            found.append(
                SweptPoint(
                    label,
                    f"key-{label}",
                    engine,
                    rule,
                    preset,
                    "step alone",
                    knobs,
                    {"steps_per_revolution": n, "solref": (0.02, 1.0)},
                    n,
                    measurement(error),
                    timing,
                )
            )
    return found


# A fit takes longer than all the rest of the study.
fitted = cache(order_of)


def orders(found: Sequence[SweptPoint], rule: str) -> ObservedOrders:
    own = [p for p in found if p.rule == rule]
    path = tuple(
        PathPoint(
            p.steps_per_revolution,
            p.measurement.outcome,
            {q: p.error(q) or 0.0 for q in QUANTITIES} if p.completed else None,
        )
        for p in own
    )
    done = [p for p in own if p.completed]
    steps = [p.steps_per_revolution for p in done]
    return ObservedOrders(
        own[0].engine,
        rule,
        own[0].path,
        {},
        (),
        path,
        {q: fitted(tuple(steps), tuple(p.error(q) or 0.0 for p in done)) for q in QUANTITIES},
    )


def convergence(engine: str, rule: str, share: Share, path: str = "step alone") -> GridConvergence:
    shares = dict.fromkeys(QUANTITIES, share)
    return GridConvergence(engine, rule, path, 1.0, (GridTriple((20, 100, 500), shares),), shares, ())


def part(name: str, size: float, predicted: float | None = None, known: float | None = 1e-13) -> Part:
    norms = {q: Norm(size, size / 2.0, known) for q in QUANTITIES}
    return Part(name, {}, norms, {}, predicted, "regularisation (1 - d) A f" if predicted else "")


BUDGET = ErrorBudget(
    "saw-500rpm",
    "mujoco",
    "stock",
    {"steps_per_revolution": 1000},
    {"position": 0.041},
    (
        part("total", 0.04, known=None),
        part("iteration", 0.0),
        part("step", 1e-3),
        part("model", 0.039, predicted=0.038),
        replace(part("regularisation, this step", 0.039, predicted=0.5), changes={"hardening": (None, 1e-9)}),
        Part("stabilisation, this step", {"solref": ((0.02, 1.0), (0.01, 1.0))}, None, {"converged": "opened"}),
    ),
)


def variation(name: str, value: float | None, ratio: float | None) -> Variation:
    errors = None if ratio is None else dict.fromkeys(QUANTITIES, 0.04 * ratio)
    ratios: dict[str, float | None] = dict.fromkeys(QUANTITIES, ratio)
    return Variation(
        name, value, "opened" if ratio is None else "completed", errors, ratios, None if ratio is None else 0.0
    )


SENSITIVITY = Sensitivity(
    "saw-500rpm",
    "mujoco",
    "stock",
    {"steps_per_revolution": 1000, "gravity": True},
    "slider_mass",
    (
        variation("as is", None, 1.0),
        variation("slider_mass x 0.01", 0.06, 0.25),
        variation("slider_mass x 100", 600.0, None),
        variation("gravity switched", None, 1.001),
    ),
)


def handmade_sweep() -> SweepStudy:
    """The sweep."""
    found = points("mujoco") + points("pymunk")
    return SweepStudy(
        name="saw-500rpm",
        scene=SCENES["saw-500rpm"],
        grid="coarse",
        engines={"mujoco": "4.0.0", "pymunk": "7.3.1"},
        machine="a machine",
        points=tuple(found),
        orders=tuple(orders(found, rule) for rule in dict.fromkeys(p.rule for p in found)),
        grid_convergence=(
            convergence("mujoco", STOCK[0], Share(9, 91, 0, 20, 5, 0.05)),
            convergence("mujoco", HARD[0], Share(99, 1, 7, 0, 0, 1.25)),
            convergence("mujoco", FAST[0], Share(60, 40, 0, 0, 0, 1.1), "step with softness"),
        ),
        both_ways=(convergence("mujoco", "stock", Share(9, 91, 0, 20, 5, 0.05)),),
        budgets=(BUDGET,),
        sensitivities=(SENSITIVITY,),
    )
