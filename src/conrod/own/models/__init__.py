"""A user's own MuJoCo model against the exact motion of a scene."""
