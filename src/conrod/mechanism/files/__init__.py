"""Mechanism files: TOML, read into checked data, table by table."""
