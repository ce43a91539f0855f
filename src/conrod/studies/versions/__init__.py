"""What each release of an engine changed."""
