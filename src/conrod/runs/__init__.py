"""What an engine did: trajectories, outcomes, errors against the exact motion."""
