"""Reports: saved results as tables, figures and pages."""
