"""The report on a table that was judged."""
