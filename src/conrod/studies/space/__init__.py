"""Machines in space in several engines, compared with their closed forms."""
