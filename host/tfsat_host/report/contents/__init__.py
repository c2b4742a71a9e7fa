"""What a report shows: an evaluation put into curves, numbers and tables for people."""
