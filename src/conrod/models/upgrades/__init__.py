"""What an upgrade of MuJoCo changes in a user's own model."""
