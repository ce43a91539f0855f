"""What a MuJoCo model carries that its motion does not require, and what makes it fail."""
