"""A run of a user's own, driven by a torque on the crank, judged by the exact motion under that torque."""
