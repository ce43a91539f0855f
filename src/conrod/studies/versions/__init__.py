"""Measured changelog of an engine: its releases, each in an environment of its own, on the same runs."""
