"""A user's own model, inspected without any option: it loads, it closes, what moves it, how exact it is."""
