"""Error and cost over many settings, and the cheapest settings within tolerances."""
