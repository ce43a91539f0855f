"""Findings on a user's model in sentences, the same on the console and on the page."""

from __future__ import annotations

import math
from collections.abc import Mapping

from conrod.own.models.frame import Frame
from conrod.own.models.lengths import Explanation, Length, Misplaced
from conrod.own.models.references import ALL_LENGTHS
from conrod.own.models.request import Wiring
from conrod.own.models.runs import QUANTITIES, JudgedRun
from conrod.own.models.study import EXACT_SOLVER, OWN, ModelStudy
from conrod.report import numbers
from conrod.scenes import Scene


def run_cells(study: ModelStudy, run: JudgedRun) -> tuple[str, ...]:
    """A run as cells of a table: settings, steps a revolution, largest errors, verdict."""
    errors = (numbers.measured(run.worst(quantity)) for quantity in QUANTITIES)
    if run.errors is None:
        said = f"{run.outcome.slug}: {run.reason}"
    elif run is study.own and study.tolerance:
        said = "OUT OF TOLERANCE" if study.exceeded() else "within tolerance"
    elif run.label == OWN and run is not study.own:
        said = "contains what the drive changes"
    else:
        said = "measured"
    return run.label, numbers.quantity(run.steps_per_revolution, 5), *errors, said


def drive(study: ModelStudy) -> list[str]:
    """Drive of the crank, and its share of the errors."""
    own = study.own
    if own is None:
        return ["not driven: it is too far off the machine for its runs to say anything"]
    found = [
        f"crank driven by an armature of {numbers.quantity(own.armature, 3)} set in the compiled model: speed constant "
        f"to {numbers.measured(own.ripple)}, crank angle off the nominal by {numbers.measured(own.phase)} rad"
    ]
    share: Mapping[str, float] | None = study.drive_share
    if share is not None:
        sizes = ", ".join(f"{name} {numbers.measured(size)}" for name, size in share.items())
        found.append(
            f"with the solver tolerance at 0 the errors change by {sizes}: that is the drive's, not the model's"
        )
    elif EXACT_SOLVER not in study.runs and OWN in study.runs:
        found.append("the solver tolerance is 0 as it is: the drive takes nothing from it")
    elif EXACT_SOLVER in study.runs:
        found.append("what the drive changes is not known: a run did not complete")
    found += [f"{preset}: {reason}" for preset, reason in study.refused.items()]
    if own.warnings:
        found.append("warnings of the engine: " + ", ".join(f"{n} {count}x" for n, count in own.warnings.items()))
    left_out = [name for name in study.identity.off_by if name not in study.points]
    if left_out:
        found.append(f"compared without {', '.join(left_out)}, which is not where it should be")
    if study.identity.explanations:
        found.append("compared with the exact motion of the lengths that were found")
    elif not study.is_machine and not study.identity.other_branch:
        found.append("the errors contain what the lengths do not explain")
    return found


def own_settings(study: ModelStudy) -> str:
    """The settings that the model comes with."""
    has = study.model.settings
    softness = ", ".join(f"{a:g} {b:g}" for a, b in has.closure_solref) or "none"
    impedance = ", ".join(f"{a:g} {b:g}" for a, b in has.closure_impedance) or "none"
    return (
        f"timestep {has.timestep:g} s, integrator {has.integrator}, solver {has.solver}, {has.iterations} iterations, "
        f"tolerance {has.tolerance:g}; closures: solref {softness}, solimp {impedance}; gravity "
        f"{' '.join(f'{g:g}' for g in has.gravity)}"
    )


MM = 1e3
TOLD_TOGETHER = 4
# Lengths that leave more than this share of what the expected ones leave explain nothing.
NEAREST = 0.05
# Shares beyond this are written as factors: 99.9 % too short says little.
FEW = 0.5


def verdict(study: ModelStudy) -> str:
    """The answer in a sentence."""
    if not study.is_machine:
        return f"It is not {study.scene_name} as it stands: {_why_not(study)}."
    if study.model.stops:
        return f"It is {study.scene_name}, but limits keep it from its turn: {'; '.join(study.model.stops)}."
    own = study.own
    if own is None or own.outcome.slug != "completed":
        how = "did not run" if own is None else f"ended as {own.outcome.slug}: {own.reason}"
        return f"It is {study.scene_name}, but with its own settings it {how}."
    over = study.exceeded()
    if over:
        found = ", ".join(f"{n} {numbers.measured(f)} > {numbers.measured(a)}" for n, (f, a) in over.items())
        return f"It is {study.scene_name}; its own settings are out of tolerance: {found}."
    judged = "within tolerance" if study.tolerance else "measured, not judged"
    return f"It is {study.scene_name}; its own settings are {judged}."


def _why_not(study: ModelStudy) -> str:
    identity = study.identity
    if identity.other_branch:
        return "it is on the other assembly branch"
    if identity.explanations:
        return " or ".join(explanation(e) for e in identity.explanations[:TOLD_TOGETHER])
    off = f"its points are off by up to {numbers.measured(identity.largest)} of their travel"
    return "; ".join([off, *([kinds] if (kinds := other_kinds(study)) else [])])


# -- frame -----------------------------------------------------------------------------------------------------------


def frame(study: ModelStudy) -> list[str]:
    """Parts of the frame that were given, and those that were worked out."""
    there, said = study.identity.frame, study.identity.given
    parts = {
        "plane": (f"plane {_plane(there)}", said.plane),
        "rotation": (f"turned by {degrees(there.rotation)}", said.rotation),
        "zero": (f"crank zero at {degrees(there.zero)}", said.zero),
        "unit": (f"unit {there.unit_name}", said.unit),
    }
    given = ", ".join(text for text, value in parts.values() if value is not None)
    worked_out = ", ".join(text for text, value in parts.values() if value is None)
    anchor = " ".join(f"{value:.6g}" for value in there.anchor)
    way = "with" if there.sense > 0 else "against"
    return [
        *([f"given: {given}"] if given else []),
        *([f"worked out: {worked_out}"] if worked_out else []),
        f"the crank's axis is at ({anchor}) {there.unit_name}; the crank angle grows {way} the hinge's coordinate",
    ]


def _plane(there: Frame) -> str:
    name = there.view.name.removeprefix("-") if there.view.name == "-askew" else there.view.name
    return f"{name}{', seen from behind' if there.view.behind else ''}"


def degrees(angle: float) -> str:
    """An angle, in as many digits as it has."""
    value = math.degrees(angle)
    whole = round(value)
    return f"{whole} deg" if abs(value - whole) < 1e-9 else f"{value:.6f} deg"


# -- wiring ----------------------------------------------------------------------------------------------------------


def wiring(study: ModelStudy) -> list[str]:
    """Joints, closures, freedom and what closes nothing."""
    has, model = study.model.wiring, study.model
    found = [f"{_counted(has)}; {_plural(has.loops, 'loop')}; the machine has {machine_joints(study.scene)}"]
    low, high = has.rank
    taken = f"{high}" if low == high else f"{low} to {high}, as it turns,"
    free = has.coordinates - high - (1 if model.touching else 0)
    contact = f" and the contact of {' and '.join(model.touching.geoms)} 1" if model.touching else ""
    found.append(
        f"mobility {free} along the whole turn: {has.coordinates} degrees of freedom, of which closures take {taken}"
        f"{contact}"
    )
    if has.idle:
        found.append(f"redundant, they close nothing that the others do not: {', '.join(has.idle)}")
    if has.inactive:
        found.append(f"switched off: {', '.join(has.inactive)}")
    if model.gap > 1e-9:
        found.append(f"{model.open_closure} cannot close: {numbers.measured(model.gap)} remain of it, in its own unit")
    return found


def _counted(has: Wiring) -> str:
    kinds = [*has.joints.items(), *((_closure(kind), count) for kind, count in has.closures.items())]
    return ", ".join(_plural(count, kind) for kind, count in kinds)


def _closure(kind: str) -> str:
    return kind if kind in ("connect", "weld") else f"equality of {kind}s"


def machine_joints(scene: Scene) -> str:
    """The joints of a machine by kind."""
    kinds = {"Revolute": "pin", "Prismatic": "slide", "CamContact": "contact", "Rolling": "gear", "Rack": "rack"}
    counts: dict[str, int] = {}
    for joint in scene.mechanism().joints:
        kind = kinds[type(joint).__name__]
        counts[kind] = counts.get(kind, 0) + 1
    return ", ".join(_plural(count, kind) for kind, count in counts.items())


def other_kinds(study: ModelStudy) -> str:
    """Joints of other kinds than those of the machine; empty where they agree."""
    has, wanted = study.model.wiring, [type(joint).__name__ for joint in study.scene.mechanism().joints]
    pins = has.joints.get("hinge", 0) + has.closures.get("connect", 0)
    slides = has.joints.get("slide", 0)
    if (pins, slides) == (wanted.count("Revolute"), wanted.count("Prismatic")) or has.idle:
        return ""
    differs = f"it has {_counted(has)}, the machine {machine_joints(study.scene)}"
    return f"{differs}: is a joint of another kind, or a link missing?"


def _plural(count: int, name: str) -> str:
    return f"{count} {name}{'' if count == 1 else 's'}"


# -- lengths ---------------------------------------------------------------------------------------------------------


def paths(study: ModelStudy) -> list[str]:
    """Comparison of the points' paths with the exact ones, and what explains the difference."""
    identity, shape = study.identity, study.model.touching
    off = ", ".join(
        f"{name} {numbers.measured(size)} of its travel ({numbers.measured(MM * size * study.scene.lengths[name])} mm)"
        for name, size in identity.off_by.items()
    )
    branch = " of the other branch" if identity.other_branch else ""
    found = [f"largest distance from the exact path{branch}: {off}"]
    if identity.rate_off is not None:
        with_found = ", with what was found," if identity.explanations else ""
        found.append(
            f"error of their derivatives by the crank angle{with_found}: {numbers.measured(identity.rate_off)}"
        )
    if shape is not None:
        size = numbers.measured(MM * identity.frame.unit * shape.shape_error)
        found.append(f"error of the collision shapes, {shape.corners} corners around the crank: {size} mm")
    if identity.other_branch:
        found.append(
            "it is on the other assembly branch, its lengths as expected; where it is to be seen from the other "
            "side of its plane, --plane says so"
        )
    found += _explained(study)
    for group in identity.indistinct:
        found.append(f"these points cannot distinguish: {', '.join(group)}")
    missing = [p.name for p in study.scene.mechanism().observed if p.name not in identity.off_by]
    if missing:
        found.append(f"not given, so not judged: {', '.join(missing)}")
    return found


def _explained(study: ModelStudy) -> list[str]:
    identity = study.identity
    if identity.explanations:
        found = [f"{explanation(e)}; that leaves {numbers.measured(e.left)}" for e in identity.explanations]
        if len(found) == 1:
            return found
        return [f"{len(found)} explanations leave nothing; the paths cannot distinguish them", *found[:TOLD_TOGETHER]]
    if identity.closest is None:
        return [] if identity.other_branch else ["all lengths are as expected"]
    found = [
        f"no lengths explain it: what comes nearest leaves {numbers.measured(identity.closest.left)} of the travel"
    ]
    if identity.closest.left < NEAREST * identity.largest:
        found.append(f"nearest: {explanation(identity.closest)}")
    kinds = other_kinds(study)
    return [*found, *([kinds] if kinds else [])]


def explanation(found: Explanation) -> str:
    """Lengths and places that are off, with their sizes."""
    return " and ".join([*(length(one) for one in found.lengths), *(misplaced(one) for one in found.misplaced)])


def length(one: Length) -> str:
    """'rod is 0.01 % too long: 325.0325 mm instead of 325 mm'."""
    excess = one.excess
    if excess is None:
        return f"{one.name} is {MM * one.found:.6g} mm instead of 0 mm"
    way = "long" if excess > 0.0 else "short"
    share = f"{numbers.rounded(100.0 * abs(excess), 2):g} % too {way}"
    if one.name == ALL_LENGTHS:
        return (
            f"all lengths are {share}" if abs(excess) < FEW else f"all lengths are {one.found:.4g} times those expected"
        )
    digits = max(6, 2 - math.floor(math.log10(abs(excess) or 1.0)) + 1)
    return f"{one.name} is {share}: {MM * one.found:.{min(digits, 15)}g} mm instead of {MM * one.expected:.6g} mm"


def misplaced(one: Misplaced) -> str:
    """A point off its place."""
    return f"{one.point} is {MM * one.away:.4g} mm from where it should be on its link"
