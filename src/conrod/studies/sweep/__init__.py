"""The trade of speed for accuracy over a grid of settings."""
