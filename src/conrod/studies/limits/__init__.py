"""Where an engine stops being trustworthy, how it fails there, and whether one would notice."""
