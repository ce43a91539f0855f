"""How runs are carried out: in order, in local processes, on a cluster."""
