"""Trajectories of any tool, as tables: read, put on the scene's clock and frame, judged against the exact motion."""
