"""Limits: values at which an engine stops being trustworthy, and how it fails there."""
