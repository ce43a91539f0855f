"""The cheapest settings within given tolerances."""
