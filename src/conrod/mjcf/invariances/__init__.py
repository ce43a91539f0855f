"""Invariances of a MuJoCo model: changes that must not matter, and the size of what they change."""
