"""What a scene's model needs, and what it merely carries: ingredients added to the minimal model and taken away."""
