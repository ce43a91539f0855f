"""Speed against accuracy: sweeps over grids of settings, and recommendations within tolerances."""
