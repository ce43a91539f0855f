"""Files of users: their MuJoCo models, tables and printed values."""
