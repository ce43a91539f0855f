"""A user's MuJoCo model, judged by the exact motion of the scene that it is to be."""
