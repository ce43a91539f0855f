"""The report of an audit: a page for each document, an index, and the numbers."""
