"""The report on engines' free motion."""
