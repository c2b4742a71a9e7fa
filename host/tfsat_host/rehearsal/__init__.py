"""A drop rehearsed on a desk: the robot's own binaries, a hidden truth, and whatever may go wrong."""
