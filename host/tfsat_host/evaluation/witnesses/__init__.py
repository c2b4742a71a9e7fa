"""What others than the logger saw of a drop: video and laser spots."""
