"""Studies of engines on scenes: a folder for each."""
