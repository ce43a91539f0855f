"""The closed loops of users' models in several engines, compared with their own exact motion."""
