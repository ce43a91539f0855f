"""Where each engine stops being trustworthy, and how it fails there."""
