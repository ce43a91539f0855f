"""Exact motion and forces of mechanisms, with no engine: what engines are compared with."""
