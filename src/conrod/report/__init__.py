"""Validation results as Markdown, figures and JSON; reads results only and imports no engine."""
