"""Changes to a model that must not change its motion."""
