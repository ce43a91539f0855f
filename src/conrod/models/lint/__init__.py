"""What a MuJoCo model has in excess, and what makes it fail."""
