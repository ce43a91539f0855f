"""What helps a new user: words explained, the installation checked, a project begun."""
