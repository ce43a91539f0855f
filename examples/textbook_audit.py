# %% [markdown]
# # Are the numbers in this textbook right?
#
# A worked example prints the positions and velocities of a machine. You are about to use them as a reference, or you
# are about to print them. conrod computes each from the exact motion and says which hold, and what went wrong with
# those that do not.
#
# The machine is a power hacksaw, `saw-40rpm`; C is its blade. Two slips are planted.

# %%
from pathlib import Path

import conrod

BOOK = """scene,quantity,angle_deg,printed,unit,place
saw-40rpm,C position x,45,-42.49,mm,row 1
saw-40rpm,C position x,90,-113.65,mm,row 2
saw-40rpm,C position x,135,-189.31,mm,row 3
saw-40rpm,C position x,180,-200.0,mm,row 4
saw-40rpm,C velocity x,45,-0.4189,m/s,row 1
saw-40rpm,C velocity x,90,-0.2771,m/s,row 2
saw-40rpm,C velocity x,135,0.1317,m/s,row 3
saw-40rpm,C velocity x,180,0.4841,m/s,row 4
"""
Path("book.csv").write_text(BOOK, encoding="utf-8")

# %% [markdown]
# A row names the machine, the quantity, the crank angle, the digits as they are printed, and the unit. The number of
# digits says how exactly the print can be taken.

# %%
found = conrod.audit("book.csv")
print(found.text)

# %% [markdown]
# Of 8 items 3 agree.
#
# - In row 3 the position is printed as -189.31 mm and should be -183.91 mm: two digits have changed places. No rule
#   that conrod knows gives that number, so it is *not reproducible as printed*; the right one stands beside it.
# - All 4 velocities are *wrong steps*, and of one kind: each row has the next row's value. Somebody pasted the column
#   one line too high. conrod says so only because the shift reproduces every one of them.
#
# What passes is not merely near: a value *agrees* if the exact one, rounded to the printed digits, is the print. The
# counts, for a test of your own:

# %%
for kind, count in found.study.counts.items():
    print(f"{kind}: {count}")

# %% [markdown]
# ## What to do next
#
# - Mend the table and audit it again; a table without slips has `agrees` in every row.
# - Dimensions other than the scene's go into a column `parameters`: `crank=32.5mm; speed=55rpm`.
# - A machine of your own: put its file beside the table and write its name, `my_mechanism.toml`, into the column
#   `scene`.
# - As a page to hand on: `found.write("audit.html")`.
