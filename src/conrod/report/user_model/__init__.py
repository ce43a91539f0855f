"""Report on a user's own model; reads results only."""
