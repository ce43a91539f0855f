"""Runs through the releases of an engine: where something changed, and by how much."""

from matplotlib.figure import Figure


def releases_figure(study):
    return Figure()
