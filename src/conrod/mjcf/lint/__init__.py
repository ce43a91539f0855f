"""Search of a MuJoCo model for what its motion does not require, and for what makes it fail."""
