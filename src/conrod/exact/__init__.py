"""The exact motion and forces of a mechanism, from its description alone."""
