"""The table of rules: a new one is a function that judges a model on the bench, and an entry here."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from conrod.mjcf.lint import inertias, redundant, sensors, soft, solver, starting, touching
from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.findings import Finding, Note


@dataclass(frozen=True)
class Rule:
    """One kind of trouble that a model is searched for.

    Attributes:
        name: for the command line and for results.
        finds: in words, as docs/lint.md has it.
        judge: looks at a model on the bench.
        why: what it finds is harmful, where the finding does not say more.
        needs_motion: whether it needs a run that does not break.
    """

    name: str
    finds: str
    judge: Callable[[Bench], Iterator[Finding | Note]]
    why: str = ""
    needs_motion: bool = True

    def answers(self, bench: Bench) -> Iterator[Finding | Note]:
        """Findings and notes of a model, with the rule's name and reason."""
        for answer in self.judge(bench):
            match answer:
                case Note():
                    yield replace(answer, rule=self.name)
                case Finding():
                    yield replace(answer, rule=self.name, why=answer.why or self.why)


STEP = Rule(
    "step-too-long",
    "a step above the longest stable one",
    solver.unstable_step,
    "the motion is the integrator's, not the machine's",
    needs_motion=False,
)
SOLVER = Rule(
    "solver-stops-early",
    "a solver tolerance that an armature makes void; too few iterations",
    solver.unsolved,
)
RULES: tuple[Rule, ...] = (
    STEP,
    SOLVER,
    Rule(
        "soft-closure",
        "connects and welds that give way, stock softness above all",
        soft.soft_closures,
        "the loop is not closed: positions are off by the opening, accelerations by far more, and no smaller step "
        "helps",
    ),
    Rule(
        "open-start",
        "a start pose that leaves a loop open",
        starting.open_pose,
        "the closures pull it shut in the first steps: a blow that no machine gets, and speeds that stay",
        needs_motion=False,
    ),
    Rule(
        "torn-start",
        "start speeds that tear a loop",
        starting.torn_speeds,
        "the closures stop it with a blow in the first steps, and energy that the machine was given is gone",
        needs_motion=False,
    ),
    Rule(
        "joined-links-collide",
        "geoms of links that collide where a hinge, connect or weld joins them",
        touching.joined_links,
        "the contact pushes against the joint that holds the links together: friction, loads and rows of its own",
        needs_motion=False,
    ),
    Rule(
        "never-touch",
        "geoms that can collide and never do",
        touching.idle_geoms,
        "every step looks for contacts between them, in a machine that has come round and has found none",
    ),
    Rule(
        "freedom-taken-away",
        "bodies that float and are tied where they could hang",
        redundant.floating_bodies,
        "coordinates that closures take away again are solved for in every step, and are as exact as the closures "
        "are stiff",
    ),
    Rule("redundant-closure", "closures that say what others say", redundant.redundant_closures),
    Rule(
        "gravity-across",
        "gravity across the plane in which everything moves",
        inertias.gravity_across,
        "it does no work on the motion: joints and closures carry it, reactions contain it, soft closures sag by it; "
        "a machine that stands upright has its gravity in the plane",
    ),
    Rule(
        "changed-inertia",
        "masses or inertias that the compiler made others than those written",
        inertias.changed_inertias,
        "drive torques, reactions and free motion are those of another machine",
        needs_motion=False,
    ),
    Rule(
        "late-sensor",
        "a delay or an interval set on a sensor",
        sensors.late_sensors,
        "values that are paired with the state of the same step are off by what happens in the delay",
    ),
    Rule(
        "silent-reset",
        "autoreset on",
        starting.silent_reset,
        "a run that diverged is finite, smooth and wrong: the machine is back in its first pose, and one warning is "
        "the only sign of it",
        needs_motion=False,
    ),
    Rule("sensors", "noted: number and cost of all sensors", sensors.sensor_cost),
    Rule("geoms-seen", "noted: geoms that cannot collide", touching.visual_geoms),
)
