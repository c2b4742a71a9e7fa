"""What is known of one robot, with its papers, and how long it holds."""
