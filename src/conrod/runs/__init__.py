"""Runs of an engine: trajectories, outcomes, errors against the exact motion."""
