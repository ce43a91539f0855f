"""Published figures, audited by the exact motion."""
