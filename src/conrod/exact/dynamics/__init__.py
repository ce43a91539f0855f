"""Exact dynamics of a mechanism of one degree of freedom, in closed coordinates."""
