"""Validation: errors of engines against the exact motion at constant crank speed."""
