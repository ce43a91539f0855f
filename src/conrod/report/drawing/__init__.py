"""Drawings of mechanisms with their dimensions."""
