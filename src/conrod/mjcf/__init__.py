"""Care for any MuJoCo model: lint and harden."""
