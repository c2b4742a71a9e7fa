"""What the robot did, by its sensors alone: no masses, no momentum."""
