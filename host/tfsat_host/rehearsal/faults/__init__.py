"""What can go wrong on a rehearsed day: a file for each group, with its words, what it does and its size."""
