"""Engines on scenes at constant crank speed, judged by the exact motion."""
