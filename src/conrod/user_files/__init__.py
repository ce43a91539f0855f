"""Files that users bring: where they are, how they are encoded, and objects in memory in place of files."""

# Endings by which files of users are known.
MODELS = (".xml", ".mjcf", ".mjb", ".urdf")
FMUS = (".fmu",)
TABLES = (".csv", ".tsv", ".tab", ".txt", ".dat", ".npz")
FILES = MODELS + TABLES + FMUS
