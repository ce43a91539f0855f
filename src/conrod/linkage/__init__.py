"""The classic quantities of a planar linkage, from its exact motion: instant centres, polygons, dead centres."""
