"""What others than the logger recorded: events in a video, and the spots of two lasers."""
