"""Checks of a drop that need no truth: sensors against each other, gravity and momentum."""
