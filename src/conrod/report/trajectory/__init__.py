"""The report of a table that was judged."""
