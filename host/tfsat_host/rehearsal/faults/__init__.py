"""What may go wrong on the day of a drop, by name, and what the robot must then do."""
