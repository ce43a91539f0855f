"""The standing text of a report on ingredients: what was done, and what its words mean."""

from __future__ import annotations

from conrod.report.numbers import quantity
from conrod.studies.ablate.results import Verdict
from conrod.studies.ablate.verdict import AS_GOOD, COSTS, NO_CHANGE

PURPOSE = (
    "A model carries more than its motion needs. Each ingredient below was added to the minimal model alone, and each "
    "part of that model was taken from it. Then all that do no harm alone were added together, which is the fully "
    "dressed model; from it each was taken away again, and those that do harm were put on top, one by one and all. "
    "What an ingredient costs and what it changes was measured, and the verdict follows from nothing else."
)

_VERDICTS = "\n".join(f"- **{verdict.slug}**: {verdict.meaning}" for verdict in Verdict)
VERDICTS = f"""{_VERDICTS}

A motion is right if no error of it against the exact one (position, velocity, acceleration, position at the nominal \
time) is more than {AS_GOOD:g} times that of the minimal model, or than {quantity(NO_CHANGE)} where that one's is \
smaller. An ingredient costs time if the whole interval of its cost lies above {COSTS:g}: settings timed against \
themselves differ by nearly that. What an ingredient does is looked at where it is alone and where all others are \
there; harm in either counts most, then need, then cost.
"""

COLUMNS = (
    "*Cost* is CPU time with the ingredient over CPU time without it: both models in turns in one process, in short "
    "blocks through the same crank angles; the median, and in brackets the interval that holds it with 95 %. *Alone*: "
    "in the minimal model; *in full*: in the fully dressed one, which of several amounts of one thing has the last. "
    "*Change* is the largest difference of an observed point's position over the run between the two models, over the "
    "travel L. *Drive torque* is what measurement says of the torque against that of the exact motion, with the "
    "weight and the masses that the machine is described with, and over its peak. What the machine is described "
    "without, such as damping, changes it. The last column names all studies that need the ingredient although the "
    "motion may not: by what it is, and of the drive torque also where measurement says so."
)

FIGURE = (
    "Left: what each ingredient costs, filled alone, open in the fully dressed model, with the interval of the median. "
    "Right: how much it changes the position; the shaded part is no change: less than the minimal model's own error, "
    f"or than {quantity(NO_CHANGE)}."
)

MODELS = (
    "Every model that was run. Errors are the largest over the run and the observed points against the exact motion "
    "(over L, ω L, ω² L); the change is against the minimal model, of those with one ingredient taken away against the "
    "fully dressed one. The minimal model is timed against itself, which shows how far such a ratio can be relied on."
)

COUNTS = (
    "Gruebler's count knows the mechanism; the compiled model has its own degrees of freedom, of which the rank of its "
    "constraints' Jacobian is taken away, at 36 crank angles of a turn. Redundant constraints say what others say; "
    "empty rows are those that no coordinate of the model enters. The drive is not counted."
)
