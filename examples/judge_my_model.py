# %% [markdown]
# # Is my MuJoCo model the machine on the drawing?
#
# Somebody hands you a MuJoCo model of a power hacksaw. It loads, it runs, it looks right. Is it the saw on the
# drawing? conrod knows the exact motion of that saw, a *scene* by the name of `saw-500rpm`, and holds the model
# against it.
#
# So that this notebook needs no file of yours, it takes conrod's own model of the saw and plants a slip: the pin at
# the end of the rod is one millimetre too far out.

# %%
from pathlib import Path

import conrod

right = conrod.export("saw-500rpm", "mjcf")
wrong = right.replace('name="slider-pin.rod" pos="0.3 0 0"', 'name="slider-pin.rod" pos="0.301 0 0"')
assert wrong != right
Path("saw.xml").write_text(wrong, encoding="utf-8")

# %% [markdown]
# ## One call
#
# You say which file, which machine, which joint is the crank, and where the point C of the scene, the saw's blade, is
# in the model.

# %%
WHERE = {"crank": "crank", "points": {"C": "site:C"}, "revolutions": 1}
found = conrod.check("saw.xml", "saw-500rpm", **WHERE)
print(found.passed)
print(found.verdict)

# %% [markdown]
# It is not the saw, and the slip is named with its size: the rod is 301 mm long instead of 300 mm, 0.33 % too long.
# That the model begins 1 mm open is the same slip, seen from where the rod meets the slider.
#
# A plot would not have shown it. Nor would MuJoCo, which closes what does not fit as well as it can, and says nothing.
#
# ## Mended
#
# With the right rod the same call says that it is the saw, and measures how exact its own settings are.

# %%
Path("saw.xml").write_text(right, encoding="utf-8")
mended = conrod.check("saw.xml", "saw-500rpm", **WHERE)
print(mended.passed)
print(mended.text)

# %% [markdown]
# The first row of the table is the file's own run, by its own motor from its own start: its largest error of position
# is 8.1e-5 mm. The rows below are runs that conrod drives, with the file's settings and with conrod's two rules for
# better ones; with `hardened` it is 9.8e-9 mm.
#
# In a notebook `mended` alone, as the last line of a cell, shows this table, and `mended.to_pandas()` makes a data
# frame of it.
#
# ## What to do next
#
# - Say what is good enough, `tolerance={"position": "0.1 mm"}`: then rows are judged, and `passed` is about your
#   bound.
# - Let conrod plant more slips, `qualify=True`, and see which of them this check would notice.
# - A model without a scene: `conrod.check("model.xml")` says whether it loads, closes and moves, and what to set.
# - On the command line: `conrod check saw.xml --scene saw-500rpm`.
