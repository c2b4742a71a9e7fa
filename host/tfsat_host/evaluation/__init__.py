"""What a recorded drop says about the robot."""
