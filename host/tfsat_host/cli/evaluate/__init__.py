"""`tfsat-host evaluate`: what the robot did in a drop, whether the model knew, and how sure both are."""
