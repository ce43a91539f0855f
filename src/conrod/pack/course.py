"""What a pack's mechanism is driven through: turns, or the one pass of an input that cannot turn fully."""

from __future__ import annotations

from conrod.scenes import Scene


def course(scene: Scene) -> str:
    """What is to be solved."""
    return "two revolutions" if _span(scene) is None else "the pass"


def whole_course(scene: Scene) -> str:
    """The same where it has been spoken of before."""
    return "the two revolutions" if _span(scene) is None else "the pass"


def drive(scene: Scene) -> str:
    """From which crank angle to which, and when."""
    span = _span(scene)
    if span is None:
        turn = f"{scene.period:.15g} s each"
        return f"from crank angle 0 at time 0, in motion from the start, over two revolutions of {turn}"
    first, last = span if scene.speed > 0.0 else span[::-1]
    return (
        f"in motion from the start, in one pass from crank angle {first!r} rad at time {first / scene.speed:.15g} s to "
        f"{last!r} rad at {last / scene.speed:.15g} s, with crank angle 0, and the start poses, at time 0: the input "
        "cannot turn fully"
    )


def covered(scene: Scene, revolutions: int) -> str:
    """What the trajectory goes over."""
    return f"{revolutions}, from crank angle 0" if _span(scene) is None else "the pass, from its start"


def unknowns(scene: Scene) -> str:
    """What need not be known of a solution."""
    if _span(scene) is not None:
        return "An unknown frame can be worked out first: `--estimate frame`."
    return (
        "Unknown start times, crank angles, senses and frames can be worked out first: "
        "`--estimate time,phase,sense,frame`."
    )


def _span(scene: Scene) -> tuple[float, float] | None:
    return scene.kinematics.mechanism.driver.span
