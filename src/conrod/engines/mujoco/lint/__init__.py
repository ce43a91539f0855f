"""What a MuJoCo model carries that its motion does not need, and what will bite: told by effect, not by name."""
