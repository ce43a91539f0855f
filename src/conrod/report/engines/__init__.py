"""The report of engines at equal error."""
