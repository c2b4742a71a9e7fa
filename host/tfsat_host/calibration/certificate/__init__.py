"""What is known of one robot, with its recordings, and how long it holds."""
