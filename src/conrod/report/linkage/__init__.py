"""A linkage as a course draws it: its instant centres, its velocity polygon, its acceleration polygon."""
