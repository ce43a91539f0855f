"""Printed values of a textbook against the exact motion."""
