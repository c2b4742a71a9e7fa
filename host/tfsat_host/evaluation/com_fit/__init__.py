"""Whether the model explains the motion, and what in it should be corrected."""
