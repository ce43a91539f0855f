"""conrod."""
