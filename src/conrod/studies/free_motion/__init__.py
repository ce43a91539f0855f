"""Validation of free motion, which loads and inertia determine and no prescribed crank."""
