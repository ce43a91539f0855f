"""MuJoCo XLA (MJX) behind the engine interface; an extra of conrod. Models are those of MuJoCo, from its translator."""
