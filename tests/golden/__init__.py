"""Golden checks: what conrod finds today, at full precision, and whether it still finds the same.

Everything is asked of the command line, so that the checks outlive any move of the code: `tasks` lists the commands,
`extract` is the one place that knows what their outputs look like, `compare` holds records against `data/`.

On a machine of the kind that made the data (see `store`) every value comes out to the last bit. On another one a value
may differ by 1e-13 of itself or of its unit, whichever is larger. The unit is there because an error of 1e-15 of a
machine's size is a difference of two numbers of that size: what is left of it after their rounding has no digits of its
own. See `Record`.
"""
