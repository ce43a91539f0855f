"""Exudyn behind the engine interface; an extra of conrod."""
