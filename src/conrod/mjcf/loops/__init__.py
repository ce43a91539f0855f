"""Closed loops of any MuJoCo model, in space: its exact motion, and how far its engine is from it."""
