"""What each ingredient of a model costs and changes."""
