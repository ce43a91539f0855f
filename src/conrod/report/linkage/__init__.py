"""A linkage as a course draws it: instant centres, velocity and acceleration polygons."""
