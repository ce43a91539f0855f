"""Exact dynamics of a mechanism of one degree of freedom: forces that a motion takes, motion that forces make."""
