"""Planted defects, and which of them a verdict notices."""
