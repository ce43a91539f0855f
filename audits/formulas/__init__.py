"""Formulas of the documents, a function each, and their check."""
