"""What became of each commanded stroke, and of the joints that should stand."""
