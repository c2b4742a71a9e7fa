"""What a recorded drop shows of the robot."""
