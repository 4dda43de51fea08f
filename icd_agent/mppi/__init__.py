"""Model predictive path integral control in numpy."""
