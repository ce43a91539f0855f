"""Is a user's own model the machine that it is to be, and how accurate is it with its own settings?"""
