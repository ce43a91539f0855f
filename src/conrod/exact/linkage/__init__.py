"""The classic quantities of a planar linkage, from its exact motion."""
