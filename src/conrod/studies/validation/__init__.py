"""Engines against the exact motion at constant crank speed."""
