"""Exact motion of machines in space: trees of hinges, slides, balls and free joints, closed by any constraints."""
