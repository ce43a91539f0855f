"""MuJoCo models that were not made by conrod."""
