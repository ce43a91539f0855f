"""What users bring: their MuJoCo models, tables and printed values."""
