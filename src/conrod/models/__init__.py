"""What users bring, judged, and what they take away: a folder for each kind of file or question."""
