"""The cheapest settings for a model's closed loops, in sentences and as lines to paste."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from conrod.comparison.other_forces import CONTACT
from conrod.comparison.trajectory import Outcome
from conrod.mjcf.loop_results import FEWEST_STEPS, LOOPS, LoopRun, LoopStudy
from conrod.models.loops.error_words import shipped_words, with_share
from conrod.report.numbers import measured_text, quantity


def settings_words(study: LoopStudy) -> str:
    """Describe the cheapest settings within tolerance, and the next coarser and own-actuator runs."""
    if (search := study.search) is None:
        return ""
    asked = ", ".join(f"{name} {with_share(study, name, allowed)}" for name, allowed in search.allowed.items())
    if (best := search.best) is None:
        least, most = (f"{quantity(1e3 * step)} ms" for step in search.steps)
        said = f"None of the settings that were tried holds {asked}: {', '.join(search.names)}, in steps of"
        nearest = "" if search.nearest is None else f"; nearest: {_trial_words(study, search.nearest, search.allowed)}"
        return f"{said} {least} to {most}{nearest}."
    cost = f"at {measured_text(best.cost)} times the cost of its own settings"
    times = (
        f"{measured_text(search.speed)} times real time on this machine, with its own {measured_text(search.own_speed)}"
    )
    said = f"The cheapest that holds {asked}: {best.label} with a step of {quantity(1e3 * best.timestep)} ms, {cost}"
    why = "its actuators bear none" if search.borne else f"the motion would have fewer than {FEWEST_STEPS}"
    beyond = f"; no larger step was tried: {why}"
    if search.coarser is not None:
        beyond = f"; {_trial_words(study, search.coarser, search.allowed)}"
        if search.coarser.is_within(search.allowed) and search.coarser_shipped is not None:
            beyond = (
                f"; with a step of {quantity(1e3 * search.coarser.timestep)} ms and its own actuators it "
                f"{shipped_words(search.coarser_shipped)}"
            )
    said = f"{said} ({times}){beyond}."
    if search.shipped is None:
        return said
    touched = (*best.acting, *search.shipped.acting)
    harder = search.after_compiling and any(one.kind == CONTACT for one in touched)
    contacts = " Contacts of the bodies whose weights are scaled harden with its loops." if harder else ""
    return f"{said} With these and its own actuators the file {shipped_words(search.shipped)}.{contacts}"


def _trial_words(study: LoopStudy, run: LoopRun, allowed: Mapping[str, float]) -> str:
    """Describe a run: its settings, and each error that exceeds what is allowed."""
    settings = f"{run.label} with a step of {quantity(1e3 * run.timestep)} ms"
    if run.outcome is not Outcome.COMPLETED:
        return f"{settings} ended as {run.outcome.slug}: {run.reason}"
    over = run.exceeded_limits(allowed)
    return f"{settings} leaves " + ", ".join(
        f"{'loops open' if name == LOOPS else name} {with_share(study, name, found)}"
        for name, (found, _) in over.items()
    )


def lines_to_paste(study: LoopStudy) -> Iterator[tuple[str, str]]:
    """Yield what each group of lines is, and the lines: the settings as MJCF and as Python."""
    search = study.search
    if study.paste:
        yield "the cheapest settings within tolerance, to paste before </mujoco>", study.paste
        if search is not None and search.after_compiling:
            yield "and in Python after compiling, which MJCF cannot express", search.after_compiling
    if search is not None and search.python:
        yield f"{'or all of it' if study.paste else 'the cheapest settings within tolerance,'} in Python", search.python
