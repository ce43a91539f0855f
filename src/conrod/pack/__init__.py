"""A scene as a problem for other tools to solve: all that they need, and the exact solution to be judged by."""
