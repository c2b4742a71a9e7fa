"""What was done to a run, in order: each entry names files by hash, and the entry before it."""
