"""Required and unnecessary ingredients of a scene's model."""
