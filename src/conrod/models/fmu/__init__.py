"""An FMU, run and judged as a table."""
