"""Closed loops of a MuJoCo model that are made to stay closed."""
