"""Frame that all studies share: cases, results, the ledger, timings, files."""
