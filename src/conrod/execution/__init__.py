"""How the cells of a study are run: one after another, in local processes, on a cluster; and kept as they finish."""
