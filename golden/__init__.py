"""Golden checks: what conrod finds today, at full precision, and whether it still finds the same.

Everything is asked of the command line, so that the checks outlive any move of the code: `tasks` lists the commands,
`extract` is the one place that knows what their outputs look like, `compare` holds records against `data/`.
"""
