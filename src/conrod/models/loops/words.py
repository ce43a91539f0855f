"""Words on a model with closed loops: sizes of errors, how its own run ended, and its cheapest settings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from conrod.comparison.other_forces import CONTACT
from conrod.comparison.trajectory import Outcome
from conrod.mjcf.loop_results import FEWEST_STEPS, LOOPS, LoopRun, LoopStudy, ShippedRun
from conrod.report.numbers import measured_text, quantity

PAGE_UNITS = {"position": (1e3, "mm"), "velocity": (1.0, "m/s"), "acceleration": (1.0, "m/s²")}


def in_mm(size: float) -> str:
    """Return a length [m] as text in mm."""
    return f"{measured_text(1e3 * size)} mm"


def size_text(name: str, size: float) -> str:
    """Return an error of a quantity [SI] as text, in the unit of reports."""
    factor, unit = PAGE_UNITS["position" if name == LOOPS else name]
    return f"{measured_text(factor * size)} {unit}"


def shipped_words(shipped: ShippedRun) -> str:
    """Say how the file's own run ended, to follow the word `it`."""
    if shipped.outcome is not Outcome.COMPLETED:
        return f"ended as {shipped.outcome.slug}: {shipped.reason}"
    if shipped.chatter is not None:
        joint, swing = shipped.chatter
        return f"oscillates: the rate of {joint} turns back at every step, by {100 * swing:.2g} % of its range"
    open_by = f", its loops open by up to {in_mm(shipped.gap)}"
    return f"runs through its {quantity(shipped.seconds, 3)} s{open_by}"


def with_share(study: LoopStudy, name: str, size: float) -> str:
    """Return a size with its share of the range of motion, or of the largest speed or acceleration, behind it."""
    scale = study.scales.get("position" if name == LOOPS else name, 0.0)
    return f"{size_text(name, size)} ({measured_text(size / scale)} L)" if scale else size_text(name, size)


# -- the cheapest settings ---------------------------------------------------------------------------------------------


def settings_words(study: LoopStudy) -> str:
    """Describe the cheapest settings within tolerance, and the next coarser and own-actuator runs."""
    if (search := study.search) is None:
        return ""
    asked = ", ".join(f"{name} {with_share(study, name, allowed)}" for name, allowed in search.allowed.items())
    within = "" if search.ended is None else f" in {search.ended:g} s of CPU time"
    if (best := search.best) is None:
        least, most = (f"{quantity(1e3 * step)} ms" for step in search.steps)
        if within and least == most:
            return f"No settings were searched that hold {asked}: the runs before took longer than {search.ended:g} s."
        said = f"None of the settings that were tried{within} holds {asked}: {', '.join(search.names)}, in steps of"
        nearest = "" if search.nearest is None else f"; nearest: {_trial_words(study, search.nearest, search.allowed)}"
        return f"{said} {least} to {most}{nearest}."
    cost = f"at {measured_text(best.cost)} times the cost of its own settings"
    times = (
        f"{measured_text(search.speed)} times real time on this machine, with its own {measured_text(search.own_speed)}"
    )
    cheapest = f"The cheapest of those tried{within}" if within else "The cheapest"
    said = f"{cheapest} that holds {asked}: {best.label} with a step of {quantity(1e3 * best.timestep)} ms, {cost}"
    why = "its actuators bear none" if search.borne else f"the motion would have fewer than {FEWEST_STEPS}"
    beyond = f"; no larger step was tried{'' if within else f': {why}'}"
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
    """Describe a run: its settings, and each error out of tolerance."""
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
