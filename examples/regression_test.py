# %% [markdown]
# # Did somebody change my simulation?
#
# A simulator that is right today is edited tomorrow. A regression test says whether it still moves as it did, and how
# far off it is if it does not. conrod keeps what it measured in a file, the *baseline*, and compares later runs with
# it.
#
# The simulator here is a few lines of numpy that integrate the speed of a saw's blade. Yours may be any tool that
# writes a table.

# %%
import numpy as np

import conrod

saw = conrod.SCENES["saw-500rpm"]


def blade_speed(time):
    """Speed of the blade [m/s] at a time [s]: crank r, offset e."""
    r, e, t = saw.crank, saw.offset, saw.speed * time
    height = r * np.sin(t) - e
    return saw.speed * (-r * np.sin(t) + height * r * np.cos(t) / np.sqrt(saw.rod**2 - height**2))


def simulate(instant, steps=200):
    """One revolution as columns; `instant` of a step, 0 to 1, is where its speed is taken."""
    step = 2 * np.pi / saw.speed / steps
    time = step * np.arange(steps + 1)
    moved = step * np.cumsum(blade_speed(time[:-1] + instant * step))
    return {"time": time, "C": np.stack([np.concatenate([[0.0], moved]), 0 * time], axis=1)}


# %% [markdown]
# ## The first run writes the baseline
#
# It does not pass: a baseline that nobody has looked at proves nothing. Look at it, and commit it.

# %%
ASKED = {"tolerance": {"position": "3 mm"}, "baseline": "saw.json"}
first = conrod.check(simulate(0.5), saw, **ASKED)
print(first.within_tolerance, first.passed)
print(first.verdict)
again = conrod.check(simulate(0.5), saw, **ASKED)
print(again.passed)

# %% [markdown]
# ## Somebody edits the simulator
#
# The speed is now taken at the begin of each step. It still runs, and is still within the tolerance of 3.0 mm.

# %%
edited = conrod.check(simulate(0.0), saw, **ASKED)
print(edited.within_tolerance, edited.passed)
print(edited.baseline.text)

# %% [markdown]
# The test fails although nothing is out of tolerance: the blade is off by 0.011 of its stroke, and was by 3.9e-05. The
# digits that are printed behind it say how far that is beyond what rounding can change. So an edit shows that nobody
# meant to make.
#
# If it was meant, `accept=True` writes the baseline again, and the difference stands in the next review.
#
# ## What to do next
#
# - In pytest: conrod brings a fixture, `conrod_check(simulate(0.5), scene="saw-500rpm", tolerance=...)`, which keeps
#   the baselines of all tests in a folder beside them. `conrod init` writes a project with such a test and a workflow
#   for a build server.
# - A model, a scene or an FMU in place of the table: `conrod.check` takes them with the same `baseline`.
# - What would the test not notice? `qualify=True`, for scenes and models, plants defects and counts.
