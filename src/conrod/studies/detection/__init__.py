"""Would the verdict notice? Defects of known size planted into runs, and healthy runs that must pass."""
