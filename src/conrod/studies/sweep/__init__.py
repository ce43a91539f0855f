"""Speed against accuracy: sweeps over grids, and recommendations within tolerances."""
