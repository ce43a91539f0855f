"""The standing text of a report of limits: what was done, and what its words mean."""

from __future__ import annotations

from conrod.studies.limits.grade import Level

PURPOSE = (
    "Where does each engine stop being trustworthy, how does it fail there, and would you notice? Each machine "
    "below was driven along one axis after another, from harmless to hopeless, and every run was compared with the "
    "exact motion."
)

_LEVELS = "\n".join(f"- *{level.slug}*: {level.meaning}" for level in Level)
WORDS = f"""Every run is one of five things:

{_LEVELS}

Position is its largest error over the run and the observed points, divided by L, the largest distance between two \
exact positions of the point, which is the travel. A run is *quiet* if it is worse than rough and nothing says so: \
all its numbers are finite and the engine gave no warning. Words such as `opened` or `flipped` are how it ended, \
from conrod's list of outcomes.
"""

QUIET = (
    "These runs are the dangerous ones: finite numbers, no warning, wrong motion. Those in one piece come first, "
    "for they are the hardest to tell from a right motion."
)
NO_QUIET = "No run was wrong without a sign of it: each one that was gave a number that is not finite, or a warning."

BOUNDARIES = (
    "An axis is looked at in 13 places from its harmless end (left) to its hopeless one, and each boundary is then "
    "halved to two per cent. The tables give the last value that keeps the criterion. A run that fails and is well "
    "again between two of these places is missed."
)
CHART = (
    "Ticks are runs. Between two runs that ended otherwise the colour changes half-way. Marks tell how runs ended; one "
    "above a bar belongs to the stretch below it, which is too narrow to hold it. A red line below a bar: quiet."
)

REGULARISATION = (
    "A softer loop moves wrongly; one that is too hard costs the forces their digits. The drive torque shows it "
    "long before the motion does."
)
NEARNESS = (
    "Near a change point the exact motion itself is ill-conditioned. The black line is what the reference is off "
    "there, against fifty digits: below it an error is not the engine's."
)
LISTED = "Every run of the list; runs that did not complete stand above the panel, each with the mark of its end."

MAPS = (
    "Only nodes along the boundaries of safe, rough, wrong and failed were run; every other one lies in an area around "
    "which all runs were of one of these, and has the colour of the nearest."
)
NEEDS = (
    "Presets choose their iterations by a rule that knows the masses. Here their number stays, and the mass ratio goes "
    "up and down from one."
)
FLOAT = (
    "A follower floats when the gap stays above ten times its static penetration for a time that does not shrink "
    "with the step. Theory: it lets go at the speed at which the preload just gives the least acceleration that the "
    "cam asks for, and flies on a parabola."
)

DETERMINISM = (
    "Each run was made again in the same process, again after another machine had been run in between, and once "
    "more in another process. Identical means to the last bit, of all poses, rates and observed points' "
    "motion at every step; the fingerprint is the beginning of their hash, which is whole in results.json."
)

LONG_RUNS = (
    "One run each, its statistics streamed. The loop error is the largest gap of a joint since the mark before; the "
    "phase is the crank angle by the engine's account, less ω times the number of steps times their length. The "
    "last column is what a clock is off that sums its steps, beside the one that counts them, as an angle of the "
    "crank."
)

GALLERY = (
    "One run for each way in which a run can end, made to end so: proof that the name is given where it belongs. "
    "*Quiet*: nothing but the comparison told."
)

STEPS = (
    "Coming from fine steps: the last number of steps per revolution that keeps the criterion, and in brackets how "
    "the run one step coarser ended."
)
