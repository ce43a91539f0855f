"""Published figures against the exact motion."""
