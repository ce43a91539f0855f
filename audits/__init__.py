"""The four documents' printed values and formulas against the exact motion."""
