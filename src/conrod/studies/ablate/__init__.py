"""What a scene's model requires, and what is unnecessary in it."""
