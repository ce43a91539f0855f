"""The report of engines' free motion."""
