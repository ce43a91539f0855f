"""The standing text of a sweep's report: what was done, and how to read each figure."""

from __future__ import annotations

PURPOSE = (
    "What does accuracy cost? Each machine below was run with every setting of a grid, in every engine, at few and at"
    " many steps per revolution. Each run was compared with the exact motion, and its cost was measured apart from "
    "it."
)

COST = (
    "Cost is the CPU time of one simulated revolution, with nothing recorded, the least of several repeats after a "
    "warm-up; cells were timed one at a time. It is given twice: as time on this machine, and as a ratio to one step "
    "of a fixed reference loop of the same engine, timed just before in the same process. The ratio carries from one "
    "machine to another, but not from one engine to another: each has its own loop."
)

ERRORS = (
    "Errors are the largest over two revolutions and over the observed points, against the exact motion at the crank "
    "angle actually reached, divided by L (position), ω L (velocity) or ω² L (acceleration): L is the largest "
    "distance between two exact positions of the point, ω the nominal crank speed. They have no unit. Below 1e-12 an "
    "error is rounding noise."
)

ONE_PASS = (
    "An input that cannot turn fully makes one pass instead: its errors are the largest over the pass, and its cost is "
    "that of the pass, told for a revolution at the same steps."
)

WORK_PRECISION = (
    "Every dot is one run: to the left is cheap, down is accurate. A curve joins the runs of one preset from few "
    "steps to many. The solid lines join the runs that no other run of their engine beats in both cost and error (the"
    " Pareto front), the broad grey line those that none of any engine beats: whoever wants an error no larger than "
    "some value should pick the first point of the line below it. Points on the solid lines carry their label, which "
    "the table below the figure explains; `results.json` has all points, by label. The two lower scales are the same "
    "cost in steps of each engine's reference loop."
)

FAILED = (
    "Runs that did not complete have no error. They stand in the strip on top, at the cost that their steps would "
    "have: the number of steps times what a step costs in the nearest completed run of the same settings, or in the "
    "median of the engine's runs where none of these settings completed."
)

FRONTS = "Bold: on the front of all engines; otherwise on that of its own engine."

ORDERS = (
    "Each setting was refined along a path. *Step alone*: the softness of the joints stays as it is in seconds. *Step"
    " with softness*: what closes the joints is stated in steps, so it stiffens as the step shrinks. The order is "
    "fitted to e = c h^p + floor, and claimed only where neighbouring pairs of runs agree within 0.1 clear of the "
    "floor. A *plateau* (broad pale line) is an error that has stopped falling; a *floor* (dotted) is where the "
    "errors of a curve with an order end, given only where they come within 20 times of it."
)

BANDS = (
    "Who has no exact solution compares three grids of different step: from their differences follow an observed "
    "order and a band around the finest value, the grid convergence index (Roache), in which the exact value should "
    "lie. Here the exact value is known. A cell is one component of one point at one crank angle on three "
    "neighbouring grids; the band holds the error or it does not. The safety factor is 1.25 where the observed order "
    "is reasonable, else 3 (then orders are clipped, oscillating cells among these). Cells whose true error is "
    "rounding are counted apart. On the right of the figure every dot is a setting: the median of its bands over its "
    "true errors. Left of the line the band was too narrow: the study would have been reassured by a wrong result."
)

BUDGET = (
    "The signed error at each crank angle is split by exchanging one thing at a time: *iteration* is what more "
    "iterations change, *step* what a step 16 times finer changes, with softness fixed in seconds, and *model* what "
    "is then left against the exact motion: the softness itself. The signed parts sum to the whole error at each "
    "angle; their norms do not, and are not added: parts may point against each other. Below them each knob of the "
    "softness is varied alone, at this step and at the finest one: what changes is that knob's, and the two are no "
    "summands of the model's part. *Known to* is the change that the last doubling made. Over the last turn, so that "
    "what the start alone disturbs is not in it."
)

BUDGET_FIGURE = (
    "Filled marks stand for parts that are told from zero, open ones for parts no larger than what is not known of "
    "them."
)

BUDGET_LAW = "A cause is named only where the engine's documented law gives the size of the part within a quarter."

TOLD = (
    "An error of the ruler would show here: joint equations solved at the engine's own state tell its error from the "
    "gaps that its joints leave open, without any reference motion. That is the measured error to second order."
)

VARIATIONS = (
    "The exact motion of a driven linkage depends on no mass and no gravity. What an engine's motion depends on of "
    "them is softness. Settings and flywheel stay as they are; the ratio is to the error with the machine as it is."
)

TRANSFERS = (
    "Settings are stated in steps and periods, so that they mean the same on every machine. The cheapest setting "
    "within a tolerance on all scenes but one was tried on the scene left out. The last column is what it costs there"
    " over the cheapest setting that the scene's own sweep knows for the same tolerance."
)
