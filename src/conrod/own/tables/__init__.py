"""Trajectories of any tool, as tables, against the exact motion of a scene."""
