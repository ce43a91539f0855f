"""Compare a user's own MuJoCo model with the exact motion of a scene."""
