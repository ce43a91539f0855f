"""A trajectory as a table, judged by the exact motion of the scene that it is to be."""
