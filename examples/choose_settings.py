# %% [markdown]
# # How small a time step do I need?
#
# Half the step costs twice the time. Whether it buys anything depends on the engine and its settings, and cannot be
# seen in a simulation alone. Where the exact motion is known it can be measured.
#
# The machine is a power hacksaw at 500 rpm, the bound one hundredth of a millimetre.

# %%
import conrod

saw = conrod.SCENES["saw-500rpm"]
stroke = 1e3 * saw.lengths["C"]  # of the blade, point C [mm]
BOUND = 0.01  # [mm]
print(f"at {saw.speed:.2f} rad/s, 500 rpm, C moves over {stroke:.1f} mm; allowed are {BOUND} mm")

# %% [markdown]
# ## Three rules, six steps
#
# A preset is a rule for an engine's settings. `tuned` is the best of an engine's usual settings; `hardened` closes
# MuJoCo's loops more firmly than its file format allows.

# %%
RULES = {
    "MuJoCo tuned": conrod.MuJoCoSettings.tuned,
    "MuJoCo hardened": conrod.MuJoCoSettings.hardened,
    "pymunk tuned": conrod.PymunkSettings.tuned,
}
STEPS = (25, 50, 100, 200, 400, 800)  # in one revolution


def error(rule, steps):
    """Largest distance of C from its exact place in one revolution [mm]; None if the run did not complete."""
    trajectory = conrod.run(saw, rule(saw, steps), revolutions=1)
    if trajectory.outcome.slug != "completed":
        return None
    return stroke * conrod.compare(trajectory, saw).worst("position")


errors = {name: [error(rule, steps) for steps in STEPS] for name, rule in RULES.items()}
for name, found in errors.items():
    words = [f"{steps}: {off:.2g}" for steps, off in zip(STEPS, found, strict=True) if off is not None]
    enough = next((steps for steps, off in zip(STEPS, found, strict=True) if off is not None and off <= BOUND), None)
    print(f"{name}: {', '.join(words)} mm; {enough} steps are enough")

# %% [markdown]
# MuJoCo needs 100 steps with `tuned` and 50 with `hardened`; pymunk needs 800. Whoever takes the number of steps from
# one engine to another misses the bound, or pays for steps that buy nothing.
#
# No rule is the best at every step: with 25 steps `hardened` is 0.034 mm off and `tuned` 0.024 mm. Twice the steps
# leave about a quarter of pymunk's error each time, and about a sixteenth of that of `hardened`: orders two and four.
#
# ## What to do next
#
# - Cost counts, too: `conrod.recommend("saw-500rpm", {"position": "0.01 mm"})` times the settings on your machine and
#   answers with the cheapest, as lines to paste.
# - All settings of a grid, as a diagram of error and cost: `conrod.sweep("saw-500rpm").write("sweep.html")`.
# - How far does that hold? `conrod.limits("saw-500rpm")` looks for the speed, the mass ratio and the step where it
#   ends.
# - Your own machine: describe it in a file and give its name, `conrod.scene("my_mechanism.toml")`.
