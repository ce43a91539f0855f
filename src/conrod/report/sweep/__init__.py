"""The report of a sweep: figures, pages and results.json; reads results only and imports no engine."""
