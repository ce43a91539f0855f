"""Studies: what is run, and what comes out."""
