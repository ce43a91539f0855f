"""Execution of runs: in order, in local processes, on a cluster."""
