"""Files that users bring: where they are, how they are encoded, and objects in memory in place of files."""
