"""Box2D behind the engine interface; an extra of conrod."""
