"""What the sensors' mounting and zero points do to their readings, measured (paper, sec. Calibrations)."""
