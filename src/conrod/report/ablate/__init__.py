"""The report on a model's ingredients: figures, pages and results.json; reads results only and imports no engine."""
