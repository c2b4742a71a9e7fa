"""What stands in a report: an evaluation put into curves, numbers and tables for people."""
