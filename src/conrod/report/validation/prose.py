"""What a scene says of itself, with its parameters as people write them.

The standing text of the pages: what the machines are, what is compared, and what that cannot see.
"""

from __future__ import annotations

from conrod.report import numbers
from conrod.scenes import Scene


def described(scene: Scene) -> str:
    """The scene's description, with a number and its unit where it names a parameter."""
    facts = scene.parameter_facts()
    words = {
        name: " ".join(numbers.in_shown_unit(value, facts[name].unit)).removesuffix(" -")
        for name, value in scene.parameters.items()
    }
    return scene.description.format(**words)


MASSES = (
    "The document gives no masses; these are conrod's. They do not change the exact motion, but they do change the "
    "error of an engine whose joints give way under load."
)

MASSES_OF_A_FILE = (
    "Masses and inertias are those of the file. They do not change the exact motion, but they do change the error of "
    "an engine whose joints give way under load."
)

GENERIC_RULER = (
    "Ruler: the generic solver, which solves the mechanism's joint equations by Newton iteration, to rounding; no "
    "closed form of this motion is at hand. On the machines that have a closed form the two agree to 1e-12."
)

ERRORS = (
    "Every engine is compared at the crank angle, rate and angular acceleration that it actually reached, each "
    "quantity at the time that it belongs to. Errors are Euclidean norms, divided by L (position, total), ω L "
    "(velocity) or ω² L (acceleration), where L is the largest distance between two exact positions of the point and "
    "ω the nominal crank speed; they have no unit. `total` is the position against the exact one at the nominal time. "
    "Measured figures have two significant digits; below 1e-12 an error is rounding noise and reads `< 1e-12`; `n/a` "
    "means that there is no such figure: the quantity is not available, not judged, or the run did not complete."
)

PRESETS = (
    "`stock` is the engine as it comes, with the drive added; it is measured and shown, and judged only where that was "
    "asked for. `tuned` is the best that documented settings can express; MuJoCo's `hardened` also removes the "
    "regularisation of the loop closures after the model is compiled. Each is one rule in period and step for all "
    "machines, never an optimum for one."
)

KINEMATIC = (
    "Before anything is measured, the *model* is proved: the engine's own constraint machinery, used as a solver at "
    "360 prescribed crank angles over {stretch}, with no time stepping, must give the exact poses. A wrong length or a "
    "joint in the wrong place would show here, and could then not be mistaken for an error of the engine's dynamics."
)
KINEMATIC_CONTACT = (
    "For the cam this is the engine's own distance query: the crank is held and the follower placed where the gap is "
    "zero. What is left is the error of the collision shape, a polygon. There is no velocity without a step in time."
)

ORDER = (
    "Error against step, on a declared path: what a preset states in steps or periods follows the step, nothing else "
    "changes. The order is fitted to e = c h^p + floor, and claimed only where two consecutive pairs of runs agree "
    "within 0.1 and the error is 20 times the floor. Where none is claimed, the orders of neighbouring "
    "pairs of columns are printed; a plateau means that the two finest pairs show none, so that a smaller step does "
    "not help."
)

PREDICTION = (
    "A state whose joints do not close must be off by what its own gaps say: the joint equations, solved once at the "
    "engine's own state, tell its error without any reference motion. Where that is the error measured against the "
    "exact motion, the difference is the engine's and not the ruler's. Each entry gives the largest measured error, "
    "the largest error told from the gaps, and the largest difference of the two over the run (a second-order "
    "remainder: about the square of the error). Largest over the observed points, divided as above."
)

TOLERANCE = (
    "Tolerances are derived before the run, from the engine's own laws, the step, the collision shape or the printed "
    "digits; none is fitted to a result."
)

PRINTED = (
    "The document prints the motion of G every 5 degrees, in {cells} cells. The exact motion rounds to "
    "{exact_agrees} of them; a judged engine must meet each of these within 0.55 of its last printed unit (half a unit "
    "is the rounding of the print itself). The other {others} cells differ from the exact motion by more than their "
    "own rounding. Why they do is the subject of an audit of the document, which is made elsewhere: the print is what "
    "is audited, never the ruler, and no engine is asked to reproduce those cells."
)
PRINTED_STEPS = "The check runs at 7200 steps per revolution, so that the printed angles are sampled."

CAM = (
    "**Lift.** The lift error is |largest lift reached - full lift| / full lift.",
    "**Why velocity is judged in rms.** The engines collide a polygon. On a facet the slope of the lift is off that of "
    "the arc by up to half the turn from facet to facet, and at a corner it jumps; a contact that yields and recovers "
    "turns each jump into a short spike. The largest error therefore tells where a sample happened to fall; the root "
    "mean square follows from the shape and the step, and can be bounded beforehand.",
    "**Why the acceleration does not converge.** A polygon has no acceleration that converges to the cam's: every "
    "facet is flat, and every corner is passed on an arc of the roller's own radius. All the curvature of the cam is "
    "concentrated in the corners, whose turn shrinks with the facets while their number grows; the rms error stays "
    "several times ω² times the lift at any number of vertices. Acceleration is reported, and not judged. A soft "
    "contact (`stock`) shows a smoother acceleration only because it filters the corners, and pays for it with a "
    "roller that sinks into the cam.",
    "**Breaks.** The exact acceleration jumps where two arcs meet, at {breaks} deg; the follower's acceleration there "
    "is one of two values, and the order of any scheme in the max norm is limited.",
    "**Preload.** The follower is held down by a constant force of {preload} times (follower mass x largest downward "
    "acceleration), {force} N, the same for both engines and all presets, in place of gravity. Above 1 the exact "
    "motion never parts; the larger value keeps a contact that yields from parting at the corners, without which no "
    "order in the step can be observed.",
)

CAM_BREAKS = (
    "**Breaks.** The exact acceleration, or the jerk, jumps where two arcs or two laws of the cam meet, at {breaks} "
    "deg; there it is one of two values."
)

ONE_CIRCLE = (
    "The flank radius is the least one, (base + nose + centre distance) / 2: the centres of base, flank and nose are "
    "in line, and the cam is one circle, without dwell or jumps."
)

BLIND_SPOTS_LINKAGE = (
    "**Masses, inertias and gravity.** The exact motion of a linkage with a driven crank depends on none of them, so "
    "this comparison cannot tell whether they are right. A wrong mass shows only in the drive torque, in the joint "
    "reactions, in free motion, and in how far a soft joint gives way."
)
BLIND_SPOTS_CONTACT = (
    "**Masses and preload.** As long as the follower stays on the cam, the exact motion depends on neither, so this "
    "comparison cannot tell whether they are right. They decide whether the contact parts and how far it sinks."
)
COMMON_TO_ALL = (
    "**A mistake common to all.** Both engines and the ruler are built from one description of the mechanism; a wrong "
    "number in it would reach all three, and they would agree. What they share, the dimensions in the table above, is "
    "guarded by the source alone."
)
COMMON_TO_ENGINES = (
    "**A mistake common to all.** Both engines are built from one description of the mechanism; a wrong number in it "
    "would reach both, and they would agree. Two independent references guard against that: the closed form, which "
    "never reads that description, and a generic solver, which reads nothing else; they must agree to 1e-12. What "
    "both share, the dimensions in the table above, is guarded by the source document alone."
)
BLIND_SPOTS = (
    "**Forces.** Nothing here is a statement about drive torque, bearing loads, impact or energy.",
    "**The real machine.** Links are rigid and joints have neither clearance nor friction, in the exact motion and in "
    "the engines alike. Deflection, play, wear and the load of cutting are in neither.",
    "**The drive.** The crank is driven at constant speed by construction (an engine's flywheel or a body of "
    "prescribed motion). A motor that slows under load is another machine.",
    "**Other runs.** Errors hold for these parameters, this speed and this many revolutions.",
)


def blind_spots(closed_form: bool) -> tuple[str, ...]:
    """What no comparison can see, where the exact motion has a closed form or has none."""
    forces, real, *others = BLIND_SPOTS
    return (forces, real, COMMON_TO_ENGINES if closed_form else COMMON_TO_ALL, *others)
