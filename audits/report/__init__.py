"""The report on the four documents: what its pages say beyond the verdicts."""
