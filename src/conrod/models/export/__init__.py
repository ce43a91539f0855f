"""What others take away: a scene's model, its exact motion, a pack, an FMU."""
