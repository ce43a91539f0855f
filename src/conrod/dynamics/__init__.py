"""Exact dynamics of a mechanism of one degree of freedom: the forces that a motion takes, the motion that forces make."""
