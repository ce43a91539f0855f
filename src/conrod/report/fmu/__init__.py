"""The exact motion as a functional mock-up unit, FMI 3.0: a model that any simulation tool loads."""
