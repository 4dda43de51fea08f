"""What must hold for every environment and every file."""
