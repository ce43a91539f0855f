"""Endings by which files of users are known."""

MODELS = (".xml", ".mjcf", ".mjb", ".urdf")
FMUS = (".fmu",)
TABLES = (".csv", ".tsv", ".tab", ".txt", ".dat", ".npz")
FILES = MODELS + TABLES + FMUS
