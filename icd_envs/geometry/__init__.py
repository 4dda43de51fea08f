"""Pure functions on clouds, polylines and boxes."""
