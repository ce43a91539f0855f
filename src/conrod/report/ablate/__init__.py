"""The report on a model's ingredients."""
