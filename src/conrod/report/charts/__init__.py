"""Charts of engine runs, the same byte for byte wherever they are drawn."""
