"""Standing text of pages on forces."""

ERRORS = (
    "Forces as the engine tells them, less the exact ones at the crank's angle, rate and angular acceleration at that "
    "instant, over the exact peak of the quantity at constant speed. What has no peak is divided by the largest of its "
    "unit (*of others*). Pins: force on the second body along x and y; slides: along the line's normal, and the moment."
)
CONTACT = (
    "Where the cam's acceleration jumps all forces do: the largest errors are those of a step there. *Between arc "
    "joints* is the rms of what lies more than 1 deg from them, of means of 16 steps, for single values scatter from "
    "an edge of the cam's polygon to the next; it is followed over the step, and of contact judged."
)
STAMPS = "Values belong to these instants, by which they are compared; a wrong one would cost an order."
MASSES = (
    "By the exact sensitivities at constant speed: 1 % of a mass, 1 % of a length, 5 % of an inertia, and the "
    "quantity of those asked for that shows it most. Under an engine stands how many times that change "
    "its own errors look like (their projection on what the change makes): a run that was judged and looks like half "
    "of it or more has not passed. What none of the quantities depends on, no engine's error can tell."
)
NOTHING_BLIND = "No change of several properties together is hidden, but for those that none depends on."
BLIND = "Hidden together, to first order:"
