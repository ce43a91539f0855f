"""A user's MuJoCo model with its closed loops hardened, and what that changes."""
