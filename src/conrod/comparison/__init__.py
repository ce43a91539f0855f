"""A trajectory and its outcome, its errors against the exact motion, and their convergence."""
