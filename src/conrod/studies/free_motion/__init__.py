"""Motion that no drive prescribes: engines against the exact motion."""
