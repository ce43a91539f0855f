"""A scene as a problem for other tools to solve."""
