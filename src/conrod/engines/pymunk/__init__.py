"""pymunk behind the engine interface."""
