"""What conrod itself costs: `make bench`. Not part of the package."""
